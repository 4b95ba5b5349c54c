// Trains the residual network f_NN on what the analytical model missed in recorded transitions.
// One-step loss on the tangent, standardised inputs and outputs, Adam, L2, early stop on the newest
// trials, which are
// held out, and a gate: a network that does not beat "no network" there is not returned.   (paper,
// eq. 8 and "Learning details")
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "host/model/residual_network.h"

namespace sanso::learn {

/// One-step transitions in the coordinates of the network. Row-major, one row a transition.
struct TransitionSet {
  std::vector<float> features;  // (n x 46)  host::residual_features
  std::vector<float> targets;   // (n x 36)  host::residual_target
  // (n)     trial the transition was recorded in: held-out data are whole trials
  std::vector<std::uint32_t> trial;

  std::size_t size() const { return trial.size(); }
  /// Features not yet standardised, target in base axes (residual_network.h).
  void add(std::uint32_t trial_number, const host::Features& f, const model::Tangent& target);
};

struct ResidualSettings {
  double learning_rate = 1e-4;
  int batch = 128;
  double l2 = 1e-4;
  int max_epochs = 60;
  int patience = 8;
  double heldout_fraction = 0.2;
  bool held_out_decides = true;

  constexpr void visit(auto&& field) {
    field("learning_rate", learning_rate, "1", 1e-6, 1e-1, "of Adam (paper)");
    field("batch", batch, "transitions", 1, 4096, "of one Adam step (paper)");
    field(
        "l2", l2, "1", 0.0, 1.0,
        "weight of the squared weights in the standardised loss: far below the errors that remain");
    field("max_epochs", max_epochs, "epochs", 1, 10000,
          "passes over the training data; a round takes seconds, not minutes");
    field("patience", patience, "epochs", 1, 1000,
          "without a better held-out loss before training stops");
    field("heldout_fraction", heldout_fraction, "share", 0.05, 0.5,
          "of the trials, the newest, at least one: they show the motion as it is run now");
    field(
        "held_out_decides", held_out_decides, "yes or no", false, true,
        "training stops by held-out trials, and a network worse than none there is not taken; no: "
        "all data, max_epochs, always taken (paper)");
  }
};

struct ResidualTraining {
  std::optional<host::ResidualNetwork> network;  // empty when the gate refused it
  int epochs = 0;
  double train_loss = 0;  // mean squared standardised error, without the L2 term
  // sum over the tangent of weight * error^2, mean over held-out transitions
  double heldout_loss = 0;
  double heldout_loss_without = 0;  // the same without a network
};

/// How many of `trials` (at least two) are held out: the newest, at least one, never all.
std::size_t newest_heldout(std::size_t trials, double fraction);

/// Trains from `start` (its weights; the standardisation is computed anew) or from random weights.
/// weights: (36) of the tangent, for the gate. Same data, settings and seed give the same bits.
/// Throws std::invalid_argument when fewer than two trials or fewer than one batch of transitions
/// are given.
ResidualTraining train_residual(const TransitionSet& data, const model::Tangent& weights,
                                const ResidualSettings& settings, std::uint64_t seed,
                                const host::ResidualNetwork* start = nullptr);

/// Mean over the rows of sum_i weight_i (target_i - prediction_i)^2; `network` null predicts zero.
double one_step_loss(const TransitionSet& data, const std::vector<std::uint32_t>& rows,
                     const model::Tangent& weights, const host::ResidualNetwork* network);

}  // namespace sanso::learn
