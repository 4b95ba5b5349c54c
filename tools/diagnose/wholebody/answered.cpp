// Questions are asked in an order: a later one adds to what is known, or knows better.
#include <algorithm>
#include <iterator>
#include <utility>

#include "tools/diagnose/wholebody/questions.h"

namespace sanso::diagnose {

void Patch::take(Patch later) {
  const auto newer = [](auto& mine, const auto& its) {
    if (its) mine = its;
  };
  newer(friction, later.friction), newer(restitution, later.restitution);
  newer(pose_scale, later.pose_scale), newer(mass_share, later.mass_share);
  newer(imu_turn, later.imu_turn), newer(acc_bias, later.acc_bias);
  newer(gyro_bias, later.gyro_bias);
  newer(slope, later.slope), newer(pose_tilt, later.pose_tilt);
  entries.insert(entries.end(), std::make_move_iterator(later.entries.begin()),
                 std::make_move_iterator(later.entries.end()));
}

void Answered::take(Answered later) {
  if (later.weighed) {
    const std::string scale = name_of(WholeFigure::force_scale);
    std::erase_if(answers.findings, [&](const Finding& f) {
      return std::find(f.one_of.begin(), f.one_of.end(), scale) != f.one_of.end();
    });
    patch.mass_share.reset();
    weighed = true;
  }
  if (later.apart) apart = std::move(later.apart);
  if (later.shown) shown = std::move(later.shown);
  answers.take(std::move(later.answers));
  patch.take(std::move(later.patch));
}

}  // namespace sanso::diagnose
