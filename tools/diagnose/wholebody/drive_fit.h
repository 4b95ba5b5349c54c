// The regression over drive_rows.h: nuisances eliminated, terms within their bounds, groups of rows
// left out or resampled at no cost.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tools/diagnose/wholebody/drive_terms.h"

namespace sanso::diagnose {

/// Normal equations of some rows, by figure.
struct Normal {
  Eigen::MatrixXd G;
  Eigen::VectorXd c;
  double yy = 0.0;
  explicit Normal(Eigen::Index figures = 0)
      : G(Eigen::MatrixXd::Zero(figures, figures)), c(Eigen::VectorXd::Zero(figures)) {}
  /// The other's rows as well, each so many times.
  void add(const Normal& other, double times = 1.0) {
    G += times * other.G, c += times * other.c, yy += times * other.yy;
  }
  /// Squared deviations left by these figures.
  double loss(const Eigen::VectorXd& figures) const;
};

/// Rows from which to fit, with the nuisances taken out.
class Eliminated {
 public:
  Eliminated(const Normal& normal, const DriveNuisances& nuisances);
  /// Of the terms, term after term, with the nuisances.
  struct Fit {
    Eigen::VectorXd x, figures, named;  // coefficients; all figures; those of the terms alone
    double gain = 0.0;                  // of squared deviations, against the nuisances alone
    double strained = 0.0;    // squares of the nuisances, in what a nominal model may be wrong by
    double farthest = 0.0;    // the largest of them, not squared
    Eigen::Index which = -1;  // nuisance
    Eigen::VectorXd strains;  // every nuisance, in what a nominal model may be wrong by
  };
  Fit fit(const std::vector<const DriveTerm*>& active) const;
  /// Standard deviations by the rows' weights and the nuisances' priors: of a coefficient together
  /// with what the nominal model may be wrong by in the very figures that its term is made of,
  /// because a finding is held against that tolerance once.
  Eigen::VectorXd deviations(const std::vector<const DriveTerm*>& active) const;

 private:
  static Eigen::MatrixXd columns_of(const std::vector<const DriveTerm*>& active,
                                    Eigen::Index figures);
  Eigen::MatrixXd own_of(const std::vector<const DriveTerm*>& active) const;
  Eigen::MatrixXd G_, schur_, back_, spread_;
  Eigen::VectorXd c_, reduced_;
  const DriveNuisances* nuisances_;
};

/// Two ways of cutting the rows: by recording, and by what part of the motion it is. What is true
/// of one robot predicts another trial, and another part of the motion.
struct DriveGroups {
  std::vector<std::vector<Normal>> by;  // way, group
  Normal all;
};

/// RMS that these figures leave in every channel, deviations known beforehand; rows that stand out
/// count as `outlier`.
std::vector<double> left_by_channel(const DriveRows& rows, const Eigen::VectorXd& figures,
                                    double outlier);

/// By channel: robust deviation of what these figures leave, 1.4826 median |left|; `least` at
/// least, and 1 where a channel has no rows.
std::vector<double> scatter_by_channel(const DriveRows& rows, const Eigen::VectorXd& figures,
                                       double least);

/// With weights by channel (what is left there scatters by), less for rows that stand out.
DriveGroups weighed(const DriveRows& rows, const Eigen::VectorXd& figures, double outlier,
                    const StanceSettings& stance = {});

}  // namespace sanso::diagnose
