// verdict.json: keys that scripts rely on; numbers that JSON cannot hold become null.
#include "tools/diagnose/verdict/verdict.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

namespace sanso::diagnose {

namespace {

using nlohmann::ordered_json;

/// JSON has no NaN or infinity; those become null.
ordered_json number(double x) { return std::isfinite(x) ? ordered_json(x) : ordered_json(nullptr); }

ordered_json json_of(const Rival& r) {
  return {{"effect", r.effect},
          {"where", r.where},
          {"heldout_gain", number(r.heldout_gain)},
          {"behind_in_se", number(r.behind_in_se)},
          {"similarity", number(r.similarity)},
          {"refuted_by", r.said_wrong}};
}

ordered_json json_of(const Finding& f) {
  ordered_json out{{"effect", f.effect},
                   {"family", f.family},
                   {"where", f.where},
                   {"regime", f.regime},
                   {"status", to_string(f.status)},
                   {"reserve", reserve(f)}};
  ordered_json parameters = ordered_json::object();
  for (const auto& [name, p] : f.parameters) {
    parameters[name] = {{"value", number(p.value)},
                        {"unit", p.unit},
                        {"low", number(p.low)},
                        {"high", number(p.high)},
                        {"at_bound", p.at_bound}};
  }
  out["parameters"] = parameters;
  out["evidence"] = {{"p_family", number(f.p_family)},
                     {"heldout_gain", number(f.heldout_gain)},
                     {"heldout_gain_se", number(f.heldout_gain_se)},
                     {"heldout_gain_low", number(f.heldout_gain_low)}};
  out["one_of"] = f.one_of;
  out["rivals"] = ordered_json::array();
  for (const Rival& r : f.rivals) out["rivals"].push_back(json_of(r));
  out["incidence"] = ordered_json::array();
  for (const IncidenceRow& row : f.incidence) {
    out["incidence"].push_back({{"residual", to_string(row.residual)},
                                {"predicted", number(row.predicted)},
                                {"slope", number(row.slope)},
                                {"low", number(row.low)},
                                {"high", number(row.high)}});
  }
  return out;
}

ordered_json json_of(const FitScore& s) {
  return {{"nominal", number(s.nominal)}, {"baseline", number(s.baseline)},
          {"named", number(s.named)},     {"patched", number(s.patched)},
          {"noise", number(s.noise)},     {"explained", number(s.explained())}};
}

ordered_json fit_json(const Verdict& v) {
  ordered_json heldout = ordered_json::object();
  for (const auto& [horizon, scores] : v.heldout) {
    ordered_json entry = scores.all ? json_of(*scores.all) : ordered_json::object();
    ordered_json by_channel = ordered_json::object();
    for (const auto& [name, score] : scores.channels) by_channel[name] = json_of(score);
    entry["channels"] = by_channel;
    heldout[horizon.text() + "s"] = entry;
  }
  return {{"heldout", heldout}, {"recordings", v.heldout_recordings}};
}

ordered_json json_of(const LocationCell& c) {
  return {{"where", c.where},       {"regime", c.regime},     {"share", number(c.share)},
          {"lift", number(c.lift)}, {"mean", number(c.mean)}, {"q_value", number(c.q_value)}};
}

ordered_json json_of(const Defect& d) {
  return {{"file", d.file},
          {"channel", d.channel},
          {"row", d.row},
          {"defect", d.defect},
          {"message", d.message}};
}

ordered_json json_of(const Untestable& u) { return {{"effect", u.effect}, {"because", u.because}}; }

ordered_json json_of(const Detectable& d) {
  return {{"effect", d.effect},
          {"where", d.where},
          {"parameter", d.parameter},
          {"size", number(d.size)},
          {"unit", d.unit}};
}

ordered_json json_of(const NextExperiment& e) {
  return {{"what", e.what},
          {"kind", to_string(e.kind)},
          {"separates", e.separates},
          {"nats_per_second", number(e.nats_per_second)},
          {"seconds_to_100_to_1", number(e.seconds_to_100_to_1)},
          {"motion_file", e.motion_file}};
}

ordered_json json_of(const Unexplained& u) {
  return {{"channel", to_string(u.shows_in)},
          {"predictable", number(u.predictable)},
          {"p", number(u.p)},
          {"energy_share", number(u.energy_share)},
          {"where", u.where},
          {"regime", u.regime},
          {"formula", u.formula},
          {"nearest_effect", u.nearest_effect}};
}

ordered_json json_of(const Unfinished& u) {
  return {{"asking", u.asking}, {"seconds", number(u.seconds)}, {"removed", number(u.removed)}};
}

ordered_json json_of(const Outlook& o) {
  return {{"grade", to_string(o.grade)},
          {"horizon", o.horizon.text() + "s"},
          {"unit", o.unit},
          {"nominal", number(o.score.nominal)},
          {"baseline", number(o.score.baseline)},
          {"named", number(o.score.named)},
          {"left", number(o.score.patched)},
          {"noise", number(o.score.noise)},
          {"named_share", number(o.named_share)},
          {"patched_share", number(o.patched_share)},
          {"matters_from", number(o.matters_from)},
          {"matters", o.matters}};
}

ordered_json json_of(const Stretch& s) {
  return {{"recording", s.recording},
          {"where", s.where},
          {"from", number(s.from)},
          {"until", number(s.until)},
          {"level", number(s.level)}};
}

template <class T>
ordered_json list_of(const std::vector<T>& items) {
  ordered_json out = ordered_json::array();
  for (const T& item : items) out.push_back(json_of(item));
  return out;
}

template <class T>
ordered_json or_null(const std::optional<T>& item) {
  return item ? json_of(*item) : ordered_json(nullptr);
}

}  // namespace

std::string verdict_json(const Verdict& v) {
  ordered_json out{{"mismatch", v.mismatch}, {"status", to_string(v.status)}, {"answer", v.answer}};
  out["summary"] = v.summary;
  out["outlook"] = or_null(v.outlook);
  out["unfinished"] = or_null(v.unfinished);
  out["findings"] = list_of(v.findings);
  out["locations"] = list_of(v.locations);
  out["fit"] = fit_json(v);
  out["refused"] = list_of(v.refused);
  out["untestable"] = list_of(v.untestable);
  out["detectable"] = list_of(v.detectable);
  out["next_experiment"] = or_null(v.next_experiment);
  out["unexplained"] = or_null(v.unexplained);
  out["stretches"] = list_of(v.stretches);
  out["notes"] = v.notes;
  out["data_hash"] = v.data_hash;
  out["seed"] = v.seed;
  return out.dump(2) + "\n";
}

}  // namespace sanso::diagnose
