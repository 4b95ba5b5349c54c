// With f the figures of the chosen terms, the rows of a motion are expected at y = X f. With G =
// X'X added to what is recorded, and gain(terms) what terms take off the squared deviations,
//
// nats = min over rivals of  [gain(chosen) - gain(rival) with the motion  -  the same without] / 2
#include "tools/diagnose/wholebody/names_apart.h"

#include <algorithm>
#include <limits>

namespace sanso::diagnose {
namespace {

std::vector<const DriveTerm*> pointers(const std::vector<DriveTerm>& terms) {
  std::vector<const DriveTerm*> out;
  out.reserve(terms.size());
  for (const DriveTerm& t : terms) out.push_back(&t);
  return out;
}

void add_name(std::vector<std::string>& names, const std::string& name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

}  // namespace

NamesApart::NamesApart(const Asking& asking, const DriveRows& rows, const DriveChoice& choice)
    : body_(asking.body),
      known_(asking.known),
      seed_(asking.seed),
      guess_(guess_of(asking, rows, choice.figures)),
      scatter_(scatter_by_channel(rows, choice.figures, asking.stance.least_scatter)),
      current_(rows.current),
      all_(weighed(rows, choice.figures, asking.settings.imu_outlier, asking.stance).all),
      nuisances_(drive_nuisances(asking, rows)),
      figures_(choice.figures) {
  settings_.whole = asking.settings, settings_.decisions = asking.decisions;
  settings_.tolerances = asking.tolerances, settings_.stance = asking.stance;
  settings_.smoother = asking.smoother;
  if (rows.weighed)
    for (const FootForce& foot : asking.recordings.front().feet) feet_.push_back(foot.link);
  for (const JudgedDriveTerm& j : choice.terms) chosen_.terms.push_back(j.term);
  for (std::size_t i = 0; i < choice.terms.size(); ++i) {
    const JudgedDriveTerm& j = choice.terms[i];
    if (!surely_there(asking, j)) continue;
    const bool places = !j.other_places.empty();
    if (!j.rivals.empty()) add_name(names_, places ? in_words(j.term) : j.term.effect);
    for (const DriveTerm& rival : j.rivals) {
      add_name(names_, rival.effect == j.term.effect ? in_words(rival) : rival.effect);
      rivals_.push_back(chosen_);
      rivals_.back().terms[i] = rival;
    }
  }
  const Eliminated recorded(all_, nuisances_);
  chosen_.gain = recorded.fit(pointers(chosen_.terms)).gain;
  for (Rival& r : rivals_) r.gain = recorded.fit(pointers(r.terms)).gain;
}

std::shared_ptr<const NamesApart> names_apart(const Asking& asking, const DriveRows& rows,
                                              const DriveChoice& choice) {
  auto out = std::make_shared<const NamesApart>(asking, rows, choice);
  return out->decided() ? nullptr : out;
}

Normal NamesApart::predicted(const WholeRecording& tried) const {
  const std::vector<WholeRecording> recordings{tried};
  const Asking asking{body_,           recordings,          known_,
                      settings_.whole, settings_.decisions, settings_.tolerances,
                      seed_,           settings_.stance,    settings_.smoother};
  const DriveRows rows = drive_rows(asking, guess_);
  Normal out(figures_.size());
  if (!rows.why_not.empty() || rows.current != current_ || rows.weighed == feet_.empty())
    return out;
  Eigen::MatrixXd X = rows.X;
  for (std::size_t i = 0; i < rows.channel.size(); ++i)
    X.row(static_cast<Eigen::Index>(i)) /=
        rows.channel[i] < scatter_.size() ? scatter_[rows.channel[i]] : 1.0;
  out.G = X.transpose() * X;
  out.c = out.G * figures_, out.yy = figures_.dot(out.c);
  return out;
}

double NamesApart::nats(const WholeRecording& tried) const {
  Normal with = all_;
  with.add(predicted(tried));
  const Eliminated both(with, nuisances_);
  const double chosen = both.fit(pointers(chosen_.terms)).gain - chosen_.gain;
  double least = std::numeric_limits<double>::infinity();
  for (const Rival& r : rivals_)
    least = std::min(least, chosen - (both.fit(pointers(r.terms)).gain - r.gain));
  return 0.5 * std::max(0.0, least);
}

}  // namespace sanso::diagnose
