// What a motion that nobody has made yet would say of names that the recordings leave undecided.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tools/diagnose/wholebody/drive_balance.h"

namespace sanso::diagnose {

/// Names, or places of one, of drives and links, of which the recordings allow each: by
/// T-optimality (the rival may refit its numbers and all that a nominal model may be wrong by
/// before a difference counts). Rows are linear in all figures, so that nothing has to be recorded
/// to know.
class NamesApart {
 public:
  NamesApart(const Asking& asking, const DriveRows& rows, const DriveChoice& choice);

  /// No name has a rival.
  bool decided() const { return rivals_.empty(); }
  /// Each once, the chosen one first; with its places where they are what is undecided.
  const std::vector<std::string>& names() const { return names_; }
  /// The robot as it is asked about.
  const WholeBody& body() const { return body_; }
  /// What its recordings hold, and a recording that is tried must: currents; feet that are weighed.
  bool current() const { return current_; }
  const std::vector<std::string>& feet() const { return feet_; }

  /// Log-likelihood ratio that the nearest rival would be behind by, if the chosen names were true
  /// and `tried` were recorded beside what is there; 0 where it holds no stretch that can be asked.
  double nats(const WholeRecording& tried) const;

 private:
  struct Rival {
    std::vector<DriveTerm> terms;
    double gain = 0.0;  // on what is recorded
  };
  Normal predicted(const WholeRecording& tried) const;

  WholeBody body_;
  Known known_;
  Settings settings_;
  unsigned long seed_ = 1;
  DriveGuess guess_;
  std::vector<double> scatter_;  // by channel
  bool current_ = false;
  std::vector<std::string> feet_, names_;
  Normal all_;
  DriveNuisances nuisances_;
  Eigen::VectorXd figures_;
  Rival chosen_;
  std::vector<Rival> rivals_;
};

/// Null where nothing is undecided.
std::shared_ptr<const NamesApart> names_apart(const Asking& asking, const DriveRows& rows,
                                              const DriveChoice& choice);

}  // namespace sanso::diagnose
