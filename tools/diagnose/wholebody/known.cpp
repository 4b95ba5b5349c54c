// [[effect]] entries of a model whose base floats, read and written: what a diagnosis found, the
// next one knows.
#include <algorithm>
#include <array>
#include <filesystem>

#include "shared/files/input_error.h"
#include "shared/math/so3.h"
#include "tools/diagnose/wholebody/questions.h"

namespace sanso::diagnose {
namespace {

using files::InputError;

class Reader {
 public:
  Reader(const WholeBody& body, const EffectEntry& entry) : body_(body), entry_(entry) {}

  [[noreturn]] void fail(const std::string& defect, const std::string& value,
                         const std::string& expected) const {
    throw InputError((std::filesystem::path(body_.model.folder) / "model.toml").string(),
                     entry_.line, "effect." + entry_.id, defect, value, expected);
  }
  double number(const std::string& name, double otherwise) const {
    const auto at = entry_.parameters.find(name);
    return at == entry_.parameters.end() ? otherwise : at->second;
  }
  Vec3 vector(const std::array<const char*, 3>& names) const {
    return {number(names[0], 0.0), number(names[1], 0.0), number(names[2], 0.0)};
  }
  void allow_only(const std::vector<EffectParameter>& known) const {
    for (const auto& parameter : entry_.parameters) {
      const std::string& name = parameter.first;
      if (std::none_of(known.begin(), known.end(),
                       [&](const EffectParameter& p) { return p.name == name; }))
        fail("unknown parameter", name, "a parameter of " + entry_.id);
    }
  }
  /// The place of the one link that is named.
  const LinkPlace& link() const {
    if (entry_.where.size() != 1)
      fail("one place expected", std::to_string(entry_.where.size()), "where = [\"a link\"]");
    const auto at = body_.model.tree.links.find(entry_.where.front());
    if (at == body_.model.tree.links.end())
      fail("unknown link", entry_.where.front(), "a link of the URDF");
    return at->second;
  }

  /// The joints of all links that are named.
  std::vector<int> links() const {
    if (entry_.where.empty()) fail("no place", "", "where = [\"a link\"]");
    std::vector<int> out;
    for (const std::string& name : entry_.where) {
      const auto at = body_.model.tree.links.find(name);
      if (at == body_.model.tree.links.end()) fail("unknown link", name, "a link of the URDF");
      out.push_back(at->second.joint);
    }
    return out;
  }

 private:
  const WholeBody& body_;
  const EffectEntry& entry_;
};

BodyInertia& inertia_at(WholeBody& body, int joint) {
  return joint < 0 ? body.base : body.model.tree.joints[static_cast<std::size_t>(joint)].body;
}

bool of_drive(const Effect& effect) { return effect.drive && effect.drive->placed; }

/// Figures that are no key of model.toml, by joint.
std::vector<double>* beside_settings(const Effect& effect, Known& known) {
  if (effect.drive->figure == JointFigure::load) return &known.load;
  return effect.drive->figure == JointFigure::zero ? &known.zero : nullptr;
}

void apply_drive(WholeBody& body, const Effect& effect, const Reader& read,
                 const std::vector<std::string>& joints, Known& known) {
  const EffectParameter& p = effect.parameters.front();
  std::vector<double>* figures = beside_settings(effect, known);
  if (figures != nullptr) figures->resize(body.model.joints.size(), 0.0);
  const double value = read.number(std::string(p.name), p.null);
  for (const std::string& joint : joints) {
    const int j = body.model.tree.index_of(joint);
    if (j < 0) read.fail("unknown joint", joint, "a joint of the URDF");
    if (figures != nullptr)
      (*figures)[static_cast<std::size_t>(j)] += value;
    else if (!effect.fold_into(body.model.joints[static_cast<std::size_t>(j)], 0, value))
      read.fail("impossible " + std::string(p.name), std::to_string(value),
                "one that leaves the settings of " + joint + " in their range");
  }
}

void apply_payload(WholeBody& body, const Reader& read) {
  const LinkPlace& place = read.link();
  const BodyInertia point{read.number("mass", 0.0), read.vector({"x", "y", "z"}), {}};
  add_body(inertia_at(body, place.joint), moved(point, place.R_joint_link, place.p_joint_link));
}

void apply_share(WholeBody& body, const Reader& read) {
  const double factor = 1.0 + read.number("share", 0.0);
  if (!(factor > 0.0)) read.fail("impossible mass", std::to_string(factor), "share above -1");
  for (const int joint : read.links()) {
    BodyInertia& b = inertia_at(body, joint);
    b.mass *= factor;
    for (double& I : b.about_com) I *= factor;
  }
}

double scale_of(const Reader& read) {
  const double scale = read.number("scale", 1.0);
  if (!(scale > 0.1)) read.fail("impossible scale", "", "about 1");
  return scale;
}

V2 read_rotation(const Reader& read) { return {read.number("x", 0), read.number("y", 0)}; }

/// What a model of a floating base can say, as a person reads it.
std::string listed() {
  std::string out;
  for (int f = static_cast<int>(WholeFigure::mass_share); f <= static_cast<int>(WholeFigure::slope);
       ++f)
    out += name_of(static_cast<WholeFigure>(f)) + ", ";
  for (const Effect& effect : library()) {
    if (of_drive(effect)) out += std::string(effect.id) + ", ";
  }
  return "one of " + out.substr(0, out.size() - 2);
}

void apply(WholeBody& body, const EffectEntry& entry, Known& known) {
  const Reader read(body, entry);
  const Effect* effect = find_effect(entry.id);
  if (effect != nullptr) read.allow_only(effect->parameters);
  if (effect != nullptr && of_drive(*effect))
    return apply_drive(body, *effect, read, entry.where, known);
  switch (effect == nullptr ? WholeFigure::none : effect->whole) {
    case WholeFigure::mass_share:
      return apply_share(body, read);
    case WholeFigure::centre: {
      BodyInertia& b = inertia_at(body, read.link().joint);
      b.com = b.com + read.vector({"x", "y", "z"});
      return;
    }
    case WholeFigure::payload:
      return apply_payload(body, read);
    case WholeFigure::pose_scale:
      known.pose_scale = scale_of(read);
      return;
    case WholeFigure::force_scale:
      known.force_scale = scale_of(read);
      return;
    case WholeFigure::imu_bias:
      known.gyro_bias = eigen(read.vector({"gyro_x", "gyro_y", "gyro_z"}));
      known.acc_bias = eigen(read.vector({"acc_x", "acc_y", "acc_z"}));
      return;
    case WholeFigure::pose_tilt:
      known.pose_tilt = read_rotation(read);
      return;
    case WholeFigure::slope:
      known.slope = read_rotation(read);
      return;
    default:
      read.fail("effect not simulated on a floating base", entry.id, listed());
  }
}

void put(WholeBody& body, EffectEntry entry) {
  auto& effects = body.model.effects;
  const auto same = std::find_if(effects.begin(), effects.end(), [&](const EffectEntry& e) {
    return e.id == entry.id && e.where == entry.where;
  });
  if (same == effects.end())
    effects.push_back(std::move(entry));
  else
    *same = std::move(entry);
}

double had(const WholeBody& body, WholeFigure figure, const std::string& name) {
  const std::string_view id = effect_of(figure).id;
  for (const EffectEntry& e : body.model.effects) {
    if (e.id == id && e.parameters.contains(name)) return e.parameters.at(name);
  }
  return 0.0;
}

/// One number on top of another: of a scale, of a share, of what adds.
double on_top(const Effect& effect, double before, double more) {
  if (effect.whole == WholeFigure::mass_share) return (1.0 + before) * (1.0 + more) - 1.0;
  const bool scale =
      effect.whole == WholeFigure::force_scale ||
      (!effect.settings.empty() && effect.settings.front().how != SettingChange::How::added);
  return scale ? before * more : before + more;
}

/// On top of what the model says of the same joints or links. A payload comes beside another.
void put_more(WholeBody& body, EffectEntry entry) {
  const Effect& effect = *find_effect(entry.id);
  if (effect.whole == WholeFigure::payload) return body.model.effects.push_back(std::move(entry));
  for (const EffectEntry& e : body.model.effects) {
    if (e.id != entry.id || e.where != entry.where) continue;
    for (auto& [name, value] : entry.parameters) {
      if (e.parameters.contains(name)) value = on_top(effect, e.parameters.at(name), value);
    }
  }
  put(body, std::move(entry));
}

/// Roll, pitch, yaw about fixed axes.
Vec3 rpy_of(const M3& R) {
  return {std::atan2(R(2, 1), R(2, 2)), std::atan2(-R(2, 0), std::hypot(R(2, 1), R(2, 2))),
          std::atan2(R(1, 0), R(0, 0))};
}

}  // namespace

std::size_t Asking::group_of(std::size_t recording, double seconds_since_start) const {
  if (recordings.size() >= static_cast<std::size_t>(settings.recordings)) return recording;
  constexpr std::size_t kMost = 100000;
  std::size_t before = 0;
  for (std::size_t r = 0; r < recording; ++r) {
    const WholeRecording& other = recordings[r];
    before += 1 + static_cast<std::size_t>((other.t.back() - other.t.front()) / settings.block);
  }
  return std::min(before + static_cast<std::size_t>(seconds_since_start / settings.block), kMost);
}

Known apply_effects(WholeBody& body) {
  Known known;
  const std::vector<EffectEntry> entries = body.model.effects;
  for (const EffectEntry& entry : entries) apply(body, entry, known);
  return known;
}

WholeBody patched(const WholeBody& body, const Patch& patch) {
  WholeBody out = body;
  if (patch.friction) {
    out.ground.material.friction = patch.friction;
    for (ContactSetting& c : out.contacts) {
      if (c.material.friction) c.material.friction = patch.friction;
    }
  }
  if (patch.restitution) out.ground.restitution = patch.restitution;
  if (patch.pose_scale)
    put(out, {name_of(WholeFigure::pose_scale), {body.root}, {{"scale", *patch.pose_scale}}, 0});
  if (patch.mass_share) {
    const double before = had(body, WholeFigure::mass_share, "share");
    put(out, {name_of(WholeFigure::mass_share),
              {body.root},
              {{"share", (1.0 + before) * (1.0 + *patch.mass_share) - 1.0}},
              0});
  }
  const auto lean = [&](WholeFigure figure, const std::optional<V2>& more) {
    if (!more) return;
    const V2 all = *more + V2(had(body, figure, "x"), had(body, figure, "y"));
    put(out, {name_of(figure), {}, {{"x", all[0]}, {"y", all[1]}}, 0});
  };
  for (const EffectEntry& entry : patch.entries) put_more(out, entry);
  lean(WholeFigure::slope, patch.slope), lean(WholeFigure::pose_tilt, patch.pose_tilt);
  if (patch.gyro_bias || patch.acc_bias) {
    const V3 g = patch.gyro_bias.value_or(V3::Zero()), a = patch.acc_bias.value_or(V3::Zero());
    EffectEntry entry{name_of(WholeFigure::imu_bias), {body.imu.link}, {}, 0};
    const char* axes[] = {"x", "y", "z"};
    for (Eigen::Index i = 0; i < 3; ++i) {
      const std::string axis = axes[i];
      entry.parameters["gyro_" + axis] = g[i] + had(body, WholeFigure::imu_bias, "gyro_" + axis);
      entry.parameters["acc_" + axis] = a[i] + had(body, WholeFigure::imu_bias, "acc_" + axis);
    }
    put(out, entry);
  }
  if (patch.imu_turn) {
    // reading = turn * predicted: the true axes are the assumed ones turned back
    const M3 back = math::rotation_matrix(math::quat_exp(V3(-*patch.imu_turn)));
    out.imu.given = true;
    out.imu.rpy = rpy_of(eigen(rotation_of_rpy(body.imu.rpy)) * back);
  }
  return out;
}

}  // namespace sanso::diagnose
