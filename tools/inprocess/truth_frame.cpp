// One turn about the vertical and one shift, found once at the first sample of a trial.
#include "tools/inprocess/truth_frame.h"

namespace sanso::inprocess {

using model::State;

TruthFrame::TruthFrame(const std::array<double, model::kNx>& first,
                       const std::array<float, model::kNx>& first_reference) {
  const State x_world = Eigen::Map<const State>(first.data());
  const State x_ref =
      Eigen::Map<const Eigen::Matrix<float, model::kNx, 1>>(first_reference.data()).cast<double>();
  const double turn =
      math::yaw_of(model::base_quat(x_ref)) - math::yaw_of(model::base_quat(x_world));
  quat_ref_world_ = math::quat_exp({0.0, 0.0, turn});
  p_ref_world_ = model::base_position(x_ref) -
                 math::rotation_matrix(quat_ref_world_) * model::base_position(x_world);
  p_ref_world_[2] = 0.0;  // heights are absolute
}

learn::TrueSample TruthFrame::sample(const std::array<double, model::kNx>& world,
                                     const std::array<double, 2>& foot_load_N,
                                     const std::array<double, 2>& foot_clearance_m) const {
  const math::Mat3 R_ref_world = math::rotation_matrix(quat_ref_world_);
  learn::TrueSample out;
  out.x = Eigen::Map<const State>(world.data());
  out.x.segment<3>(model::kXPos) = p_ref_world_ + R_ref_world * model::base_position(out.x);
  out.x.segment<4>(model::kXQuat) = math::quat_multiply(quat_ref_world_, model::base_quat(out.x));
  out.x.segment<3>(model::kXVel) = R_ref_world * out.x.segment<3>(model::kXVel);
  for (std::size_t foot = 0; foot < 2; ++foot) {
    out.foot_load_N[foot] = static_cast<float>(foot_load_N[foot]);
    out.foot_clearance_m[foot] = static_cast<float>(foot_clearance_m[foot]);
  }
  return out;
}

}  // namespace sanso::inprocess
