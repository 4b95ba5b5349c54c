// Splits by age, identifies, trains, and keeps each part only when the newest episodes are
// predicted better with it.
#include "host/learn/model/model_learner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "host/learn/model/landings.h"
#include "host/learn/seeds.h"
#include "host/mpc/noise_columns.h"
#include "shared/files/framed.h"
#include "shared/model/op3_step.h"

namespace sanso::learn {
namespace {

constexpr char kLearnerMagic[] = "SANSOMDL";
constexpr std::uint32_t kLearnerVersion = 2;
constexpr double kHalfwayLoss = 1.0;  // E1 of the sigma law

void visit_network(auto& n, auto&& io) {
  io(n.feature_mean), io(n.feature_scale), io(n.W1), io(n.W2), io(n.W3), io(n.b1), io(n.b2),
      io(n.b3), io(n.output_mean);
  io(n.output_scale);
}

}  // namespace

double sigma_of_loss(double loss) {
  if (!std::isfinite(loss)) return kSigmaStart;
  return kSigmaFloor + (kSigmaStart - kSigmaFloor) * loss / (loss + kHalfwayLoss);
}

ModelLearner::ModelLearner(const host::AugmentedModel& initial, const model::Tangent& weights,
                           const ModelLearningSettings& settings, std::uint64_t seed)
    : initial_(initial),
      weights_(weights),
      settings_(settings),
      seed_(seed),
      map_(settings.origin                  ? *settings.origin
           : initial.analytical.foot.wheels ? model::skating_parameters()
                                            : model::nominal_parameters(),
           settings.set_up ? ParameterPrior{} : as_drawn(ParameterPrior{})),
      z_(Eigen::VectorXd::Zero(map_.size())) {}

host::AugmentedModel ModelLearner::current() const {
  host::AugmentedModel m = initial_;
  if (residual_ && trust_.share > 0.0) m.residual = with_share(*residual_, trust_.share);
  // the very bits of the initial model: going through its parameters would round
  if (z_.isZero(0.0)) return m;
  const model::ContactSettings contact = m.analytical.contact;
  const auto model_at = [&](const Eigen::VectorXd& z) {
    model::StepModel out = model::make_step_model(map_.parameters(z));
    out.contact = contact;
    return out;
  };
  m.analytical = model_at(z_);
  for (const Eigen::VectorXd& z : members_) m.spread.push_back(model_at(z));
  return m;
}

ModelLosses ModelLearner::losses(const std::vector<PredictionWindow>& windows) const {
  const host::AugmentedModel m = current();
  ModelLosses l;
  l.initial = n_step_loss(windows, initial_.analytical, initial_.ground, weights_);
  l.analytical =
      z_.isZero(0.0) ? l.initial : n_step_loss(windows, m.analytical, m.ground, weights_);
  l.augmented = m.residual ? n_step_loss(windows, m.analytical, m.ground, weights_, &*m.residual)
                           : l.analytical;
  return l;
}

std::optional<ModelLosses> ModelLearner::losses(const Episode& episode) const {
  const std::vector<PredictionWindow> windows = usable_windows(episode);
  if (windows.empty()) return std::nullopt;
  return losses(windows);
}

std::vector<PredictionWindow> ModelLearner::usable_windows(const Episode& episode) const {
  return upright_windows_of(episode, settings_.tilt_limit_rad, settings_.window_stride_ticks);
}

std::vector<PredictionWindow> ModelLearner::learning_windows(const Episode& episode) const {
  const std::vector<wire::Observation> ticks =
      without_landings(episode.ticks, settings_.flight_ticks);
  const bool whole = ticks.size() == episode.ticks.size();
  if (whole && (!episode.failed() || !settings_.failures_teach)) return usable_windows(episode);
  std::vector<PredictionWindow> windows;
  const auto add = [&](const std::vector<wire::Observation>& recording) {
    for (const PredictionWindow& w : cut_windows_of(
             recording, episode.trial, settings_.tilt_limit_rad, settings_.window_stride_ticks))
      windows.push_back(w);
  };
  if (episode.failed() && settings_.failures_teach) add(episode.before);
  add(ticks);
  return windows;
}

ModelLearner::Start ModelLearner::begin_at(const Eigen::VectorXd& z,
                                           const std::vector<PredictionWindow>& windows) {
  Start start;
  if (windows.empty()) return start;
  start.loss_initial = n_step_loss(windows, initial_.analytical, initial_.ground, weights_);
  start.loss = loss_at(z, windows);
  start.used = start.loss < start.loss_initial;
  if (start.used) z_ = z;
  return start;
}

std::optional<double> ModelLearner::begin_damped(const std::vector<PredictionWindow>& windows,
                                                 const DampingOfMovesSettings& settings) {
  const std::vector<PredictionWindow> moves = moves_of(windows, settings.moving_rad);
  if (moves.empty()) return std::nullopt;
  const auto loss = [&](const Eigen::VectorXd& z) { return loss_at(z, moves); };
  const double damping = best_damping(map_, z_, loss, settings);
  z_[damping_entry(map_)] = damping;
  return damping;
}

std::optional<double> ModelLearner::begin_refined(const std::vector<PredictionWindow>& windows) {
  if (windows.empty()) return std::nullopt;
  const std::vector<PredictionWindow> some = some_of(windows);
  z_ = refined({some, map_, initial_.ground, weights_}, prior_on(some), z_,
               settings_.identify.refine, settings_.identify.threads);
  draw_ensemble(windows);
  return loss_at(z_, windows);
}

std::vector<PredictionWindow> ModelLearner::some_of(
    const std::vector<PredictionWindow>& windows) const {
  return thinned(windows, static_cast<std::size_t>(settings_.identify.max_windows));
}

double ModelLearner::prior_on(const std::vector<PredictionWindow>& windows) const {
  return settings_.identify.prior_weight *
         n_step_loss(windows, initial_.analytical, initial_.ground, weights_) /
         static_cast<double>(map_.size());
}

void ModelLearner::draw_ensemble(const std::vector<PredictionWindow>& windows) {
  if (settings_.ensemble.members == 0) return;
  const std::vector<PredictionWindow> some = some_of(windows);
  const std::uint64_t seed =
      derived_seed(seed_, static_cast<std::uint64_t>(rounds_), Stream::ensemble);
  members_ = ensemble({some, map_, initial_.ground, weights_}, prior_on(some), z_,
                      settings_.ensemble, seed, settings_.identify.threads);
}

double ModelLearner::loss_at(const Eigen::VectorXd& z,
                             const std::vector<PredictionWindow>& windows) const {
  model::StepModel analytical = model::make_step_model(map_.parameters(z));
  analytical.contact = initial_.analytical.contact;
  return n_step_loss(windows, analytical, initial_.ground, weights_);
}

/// The newest episodes that have something to learn from: not those that fell at once.
std::vector<Episode> ModelLearner::usable(const std::vector<Episode>& all) const {
  const auto keep = std::min(all.size(), static_cast<std::size_t>(settings_.newest_episodes));
  std::vector<Episode> episodes(all.end() - static_cast<std::ptrdiff_t>(keep), all.end());
  std::erase_if(episodes, [this](const Episode& e) { return learning_windows(e).empty(); });
  return episodes;
}

ModelLearner::Data ModelLearner::split(const std::vector<Episode>& episodes) const {
  Data data;
  const std::size_t trained =
      episodes.size() - newest_heldout(episodes.size(), settings_.residual.heldout_fraction);
  for (std::size_t i = 0; i < episodes.size(); ++i) {
    auto& part = i < trained ? data.train : data.heldout;
    for (const PredictionWindow& w : learning_windows(episodes[i])) part.push_back(w);
  }
  if (!settings_.held_out_decides)
    data.train.insert(data.train.end(), data.heldout.begin(), data.heldout.end());
  return data;
}

LearningRound ModelLearner::learn(const std::vector<Episode>& all) {
  LearningRound round;
  const std::vector<Episode> episodes = usable(all);
  if (episodes.size() < 2) return round;
  const Data data = split(episodes);
  round.episodes = static_cast<int>(episodes.size());
  round.heldout_before = losses(data.heldout);
  ++rounds_;
  identify_parameters(data, round);
  if (settings_.use_residual) train_network(episodes, data, round);
  round.heldout_after = losses(data.heldout);
  sigma_ = sigma_of_loss(round.heldout_after.augmented);
  return round;
}

void ModelLearner::identify_parameters(const Data& data, LearningRound& round) {
  const std::uint64_t seed =
      derived_seed(seed_, static_cast<std::uint64_t>(rounds_), Stream::identification);
  IdentifyRun from_the_last;
  from_the_last.start_z = z_;
  const Identification found = identify(data.train, map_, initial_.ground, weights_,
                                        settings_.identify, seed, from_the_last);
  const double before = round.heldout_before.analytical;
  const double after = n_step_loss(data.heldout, model::make_step_model(found.parameters),
                                   initial_.ground, weights_);
  round.identification_used = after < before || !settings_.held_out_decides;
  if (!round.identification_used) return;
  z_ = found.z;
  draw_ensemble(data.train);
  residual_.reset();  // it was trained on what the old parameters missed
  trust_ = {};
}

void ModelLearner::train_network(const std::vector<Episode>& episodes, const Data& data,
                                 LearningRound& round) {
  host::AugmentedModel m = current();
  const TransitionSet set = transitions(episodes, m.analytical);
  if (set.size() < static_cast<std::size_t>(settings_.residual.batch)) return;
  const std::uint64_t seed =
      derived_seed(seed_, static_cast<std::uint64_t>(rounds_), Stream::residual);
  ResidualSettings training = settings_.residual;
  training.held_out_decides = training.held_out_decides && settings_.held_out_decides;
  const ResidualTraining trained =
      train_residual(set, weights_, training, seed, residual_ ? &*residual_ : nullptr);
  round.residual_one_step = trained.heldout_loss;
  round.residual_one_step_without = trained.heldout_loss_without;
  // Better over one step is not enough: the planner rolls the model out, and an error that feeds
  // itself shows only there. A share of a correction may be right where all of it adds up.
  const double in_use = n_step_loss(data.heldout, m.analytical, m.ground, weights_,
                                    m.residual ? &*m.residual : nullptr);
  const double fresh = trained.network ? loss_in_use(*trained.network, data.heldout)
                                       : std::numeric_limits<double>::infinity();
  if (fresh < kClearlyBetter * in_use || (trained.network && !settings_.held_out_decides)) {
    residual_ = trained.network;
    trust_ = {};
    if (!settings_.trust_by_trials) trust_.share = 1.0;
  }
  round.residual_kept = residual_.has_value();
}

double ModelLearner::loss_in_use(const host::ResidualNetwork& network,
                                 const std::vector<PredictionWindow>& windows) const {
  const host::AugmentedModel m = current();
  if (!settings_.trust_by_trials)
    return n_step_loss(windows, m.analytical, m.ground, weights_, &network);
  return best_share(windows, m.analytical, m.ground, weights_, network, 1.0).loss;
}

bool ModelLearner::judge_residual(const Episode& episode) {
  if (!residual_ || !settings_.trust_by_trials) return false;
  const host::AugmentedModel m = current();
  const ResidualTrust before = trust_;
  trust_ = judged(before, usable_windows(episode), m.analytical, m.ground, weights_, *residual_);
  return trust_.share != before.share;
}

TransitionSet ModelLearner::transitions(const std::vector<Episode>& episodes,
                                        const model::StepModel& analytical) const {
  TransitionSet set;
  model::StepScratch scratch;
  for (const Episode& episode : episodes) {
    const std::vector<wire::Observation> ticks =
        without_landings(episode.ticks, settings_.flight_ticks);
    std::map<int, const wire::Observation*> at;
    for (const wire::Observation& o : ticks) at[o.trial_tick] = &o;
    if (at.empty()) continue;
    for (int t = at.begin()->first; t + kTicksPerStep <= at.rbegin()->first;
         t += settings_.transition_stride_ticks) {
      const std::optional<model::Input> applied = mean_target(at, t);
      if (!applied || at.count(t + kTicksPerStep) == 0 ||
          tilt_of(at[t]->x) > settings_.tilt_limit_rad)
        continue;
      const model::Input u = PredictionWindow::acting(
          mean_target(at, t - kTicksPerStep).value_or(*applied), *applied, analytical.target_lag_s);
      model::State next;
      model::analytical_step(analytical, initial_.ground, at[t]->x.data(), u.data(), kStep_s,
                             initial_.substeps, next.data(), scratch);
      set.add(episode.trial, host::residual_features(at[t]->x, u),
              host::residual_target(at[t]->x, next, at[t + kTicksPerStep]->x));
    }
  }
  return set;
}

void ModelLearner::save(const std::filesystem::path& path) const {
  files::FramedWriter out;
  out.put(static_cast<std::uint32_t>(z_.size()));
  out.put(z_);
  out.put(static_cast<std::uint32_t>(members_.size()));
  for (const Eigen::VectorXd& z : members_) out.put(z);
  out.put(sigma_);
  out.put(static_cast<std::int32_t>(rounds_));
  out.put(static_cast<std::uint8_t>(residual_.has_value()));
  if (residual_) visit_network(*residual_, [&out](const auto& m) { out.put(m); });
  files::save_framed(path, kLearnerMagic, kLearnerVersion, out.bytes());
}

void ModelLearner::load(const std::filesystem::path& path) {
  files::FramedReader in = files::load_framed(path, kLearnerMagic, kLearnerVersion);
  if (in.read<std::uint32_t>() != static_cast<std::uint32_t>(map_.size())) {
    throw std::runtime_error(path.string() +
                             ": holds another set of model parameters; delete it and learn again");
  }
  in.get(z_);
  const auto members = in.read<std::uint32_t>();
  if (members > mpc::kMaxSpread)
    throw std::runtime_error(path.string() + ": damaged; delete it and learn again");
  members_.assign(members, z_);
  for (Eigen::VectorXd& z : members_) in.get(z);
  in.get(sigma_);
  rounds_ = in.read<std::int32_t>();
  residual_.reset();
  if (in.read<std::uint8_t>() != 0) {
    residual_.emplace();
    visit_network(*residual_, [&in](auto& m) { in.get(m); });
  }
  trust_ = {};
}

}  // namespace sanso::learn
