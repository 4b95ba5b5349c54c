// Losses of one choice less those of another, group by group: what is above chance is proved.
#include "tools/diagnose/wholebody/imu_choice.h"

#include "tools/diagnose/stats/random.h"
#include "tools/diagnose/stats/significance.h"

namespace sanso::diagnose {
namespace {

std::size_t groups_of(const std::vector<ImuWindow>& windows) {
  std::size_t most = 0;
  for (const ImuWindow& w : windows) most = std::max(most, w.group + 1);
  return most;
}

/// By group, each predicted by the other thirds.
std::vector<double> left_out(const std::vector<ImuWindow>& windows, const WholeSettings& settings,
                             const ImuParts& parts, const ImuNoise& noise) {
  const auto parts_of_groups = settings.parts_of_groups();
  std::vector<double> out(groups_of(windows), 0.0);
  for (std::size_t part = 0; part < parts_of_groups; ++part) {
    std::vector<ImuWindow> fitted;
    for (const ImuWindow& w : windows)
      if (w.group % parts_of_groups != part) fitted.push_back(w);
    const ImuMount m = fit_mount(fitted, settings, parts);
    for (const ImuWindow& w : windows)
      if (w.group % parts_of_groups == part)
        out[w.group] += loss_of(w, m, noise, settings.imu_outlier);
  }
  return out;
}

/// Whether `rich` predicts better than `simple` beyond chance.
bool proved(const std::vector<double>& simple, const std::vector<double>& rich,
            const Chance& chance) {
  std::vector<double> gained;
  for (std::size_t g = 0; g < simple.size(); ++g) gained.push_back(simple[g] - rich[g]);
  return moving_block_lower_bound(gained, chance.decisions.gain_level, chance.decisions.gain_draws,
                                  Random(chance.seed, 33)) > 0.0;
}

}  // namespace

ImuChoice choose_parts(const std::vector<ImuWindow>& windows, const Chance& chance) {
  const ImuNoise noise = noise_of(windows, fit_mount(windows, chance.whole));
  const auto losses = [&](const ImuParts& parts) {
    return left_out(windows, chance.whole, parts, noise);
  };
  const auto neither = losses({false, false}), turn = losses({true, false});
  const auto bias = losses({false, true}), both = losses({true, true});
  const bool turned = sum(turn) <= sum(bias);
  const auto& one = turned ? turn : bias;
  if (!proved(neither, one, chance)) return {{false, false}};
  if (proved(one, both, chance)) return {{true, true}};
  ImuChoice out{{turned, !turned}};
  if (turned)
    out.bias_rivals = !proved(bias, turn, chance);
  else
    out.turn_rivals = !proved(turn, bias, chance);
  return out;
}

}  // namespace sanso::diagnose
