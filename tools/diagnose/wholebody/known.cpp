// [[effect]] entries of a model whose base floats, read and written: what a diagnosis found, the
// next one knows.
#include <algorithm>
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
  void allow_only(std::initializer_list<const char*> names) const {
    for (const auto& parameter : entry_.parameters) {
      const std::string& name = parameter.first;
      if (std::none_of(names.begin(), names.end(), [&](const char* n) { return name == n; }))
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

 private:
  const WholeBody& body_;
  const EffectEntry& entry_;
};

BodyInertia& inertia_at(WholeBody& body, int joint) {
  return joint < 0 ? body.base : body.model.tree.joints[static_cast<std::size_t>(joint)].body;
}

bool of_drive(const std::string& effect) {
  return effect == "servo_p_gain" || effect == "coulomb_friction" || effect == "viscous_friction";
}

void apply_drive(WholeBody& body, const EffectEntry& entry, const Reader& read) {
  read.allow_only({"gain", "coulomb", "viscous"});
  for (const std::string& joint : entry.where) {
    const int j = body.model.tree.index_of(joint);
    if (j < 0) read.fail("unknown joint", joint, "a joint of the URDF");
    JointSettings& s = body.model.joints[static_cast<std::size_t>(j)];
    const double gain = read.number("gain", 1.0);
    s.kp *= gain, s.p_gain *= gain;
    s.coulomb += read.number("coulomb", 0.0), s.viscous += read.number("viscous", 0.0);
  }
}

void apply(WholeBody& body, const EffectEntry& entry, Known& known) {
  const Reader read(body, entry);
  if (entry.id == "link_mass") {
    read.allow_only({"share"});
    BodyInertia& b = inertia_at(body, read.link().joint);
    const double factor = 1.0 + read.number("share", 0.0);
    if (!(factor > 0.0)) read.fail("impossible mass", std::to_string(factor), "share above -1");
    b.mass *= factor;
    for (double& I : b.about_com) I *= factor;
  } else if (entry.id == "link_com") {
    read.allow_only({"x", "y", "z"});
    BodyInertia& b = inertia_at(body, read.link().joint);
    b.com = b.com + Vec3{read.number("x", 0), read.number("y", 0), read.number("z", 0)};
  } else if (entry.id == "payload") {
    read.allow_only({"mass", "x", "y", "z", "from"});
    const LinkPlace& place = read.link();
    const BodyInertia point{read.number("mass", 0.0),
                            {read.number("x", 0), read.number("y", 0), read.number("z", 0)},
                            {}};
    add_body(inertia_at(body, place.joint), moved(point, place.R_joint_link, place.p_joint_link));
  } else if (of_drive(entry.id)) {
    apply_drive(body, entry, read);
  } else if (entry.id == "pose_scale") {
    read.allow_only({"scale"});
    known.pose_scale = read.number("scale", 1.0);
    if (!(known.pose_scale > 0.1)) read.fail("impossible scale", "", "about 1");
  } else if (entry.id == "foot_force_scale") {
    read.allow_only({"scale"});
    known.force_scale = read.number("scale", 1.0);
    if (!(known.force_scale > 0.1)) read.fail("impossible scale", "", "about 1");
  } else if (entry.id == "imu_bias") {
    read.allow_only({"gyro_x", "gyro_y", "gyro_z", "acc_x", "acc_y", "acc_z"});
    known.gyro_bias = {read.number("gyro_x", 0), read.number("gyro_y", 0),
                       read.number("gyro_z", 0)};
    known.acc_bias = {read.number("acc_x", 0), read.number("acc_y", 0), read.number("acc_z", 0)};
  } else if (entry.id == "ground_slope" || entry.id == "pose_tilt") {
    read.allow_only({"x", "y"});
    V2& rotation = entry.id == "pose_tilt" ? known.pose_tilt : known.slope;
    rotation[0] = read.number("x", 0), rotation[1] = read.number("y", 0);
  } else {
    read.fail("effect not simulated on a floating base", entry.id,
              "link_mass, link_com, payload, pose_scale, pose_tilt, foot_force_scale, imu_bias, "
              "ground_slope, servo_p_gain, coulomb_friction or viscous_friction");
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

double had(const WholeBody& body, const std::string& id, const std::string& name) {
  for (const EffectEntry& e : body.model.effects) {
    if (e.id == id && e.parameters.contains(name)) return e.parameters.at(name);
  }
  return 0.0;
}

/// On top of what the model says of the same joints: gains multiply, frictions add.
void put_drive(WholeBody& body, EffectEntry entry) {
  for (const EffectEntry& e : body.model.effects) {
    if (e.id != entry.id || e.where != entry.where) continue;
    for (auto& [name, value] : entry.parameters) {
      if (!e.parameters.contains(name)) continue;
      const double before = e.parameters.at(name);
      value = name == "gain" ? value * before : value + before;
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

int Asking::group_of(std::size_t recording, double seconds_since_start) const {
  if (recordings.size() >= static_cast<std::size_t>(settings.recordings))
    return static_cast<int>(recording);
  constexpr int kMost = 100000;
  int before = 0;
  for (std::size_t r = 0; r < recording; ++r) {
    const WholeRecording& other = recordings[r];
    before += 1 + static_cast<int>((other.t.back() - other.t.front()) / settings.block);
  }
  return std::min(before + static_cast<int>(seconds_since_start / settings.block), kMost);
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
  if (patch.pose_scale) put(out, {"pose_scale", {body.root}, {{"scale", *patch.pose_scale}}, 0});
  if (patch.mass_share) {
    const double before = had(body, "link_mass", "share");
    put(out, {"link_mass",
              {body.root},
              {{"share", (1.0 + before) * (1.0 + *patch.mass_share) - 1.0}},
              0});
  }
  const auto lean = [&](const char* effect, const std::optional<V2>& more) {
    if (!more) return;
    put(out,
        {effect,
         {},
         {{"x", (*more)[0] + had(body, effect, "x")}, {"y", (*more)[1] + had(body, effect, "y")}},
         0});
  };
  for (const EffectEntry& entry : patch.entries) put_drive(out, entry);
  lean("ground_slope", patch.slope), lean("pose_tilt", patch.pose_tilt);
  if (patch.gyro_bias || patch.acc_bias) {
    const V3 g = patch.gyro_bias.value_or(V3::Zero()), a = patch.acc_bias.value_or(V3::Zero());
    EffectEntry entry{"imu_bias", {body.imu.link}, {}, 0};
    const char* axes[] = {"x", "y", "z"};
    for (Eigen::Index i = 0; i < 3; ++i) {
      const std::string axis = axes[i];
      entry.parameters["gyro_" + axis] = g[i] + had(body, "imu_bias", "gyro_" + axis);
      entry.parameters["acc_" + axis] = a[i] + had(body, "imu_bias", "acc_" + axis);
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
