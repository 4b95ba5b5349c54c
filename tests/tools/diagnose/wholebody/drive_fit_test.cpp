// The regression of the drives against the same sums solved in one piece.
#include "tools/diagnose/wholebody/drive_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "tools/diagnose/stats/random.h"

namespace sanso::diagnose {
namespace {

constexpr double kFree = 1e9;

Eigen::MatrixXd drawn(Random& random, Eigen::Index rows, Eigen::Index columns) {
  Eigen::MatrixXd out(rows, columns);
  for (Eigen::Index i = 0; i < out.size(); ++i) out.data()[i] = random.normal();
  return out;
}

struct Drawn {
  Eigen::MatrixXd X;
  Eigen::VectorXd y;
  Normal normal{6};
  DriveNuisances nuisances;
  explicit Drawn(std::uint64_t seed) {
    Random random(seed);
    X = drawn(random, 40, 6), y = drawn(random, 40, 1);
    normal.G = X.transpose() * X, normal.c = X.transpose() * y, normal.yy = y.squaredNorm();
    nuisances.columns = drawn(random, 6, 2);
    nuisances.precision = Eigen::Vector2d(3.0, 70.0);
  }
  /// The figures that make squares and priors least, terms free.
  Eigen::VectorXd in_one_piece(const Eigen::MatrixXd& terms) const {
    Eigen::MatrixXd A(6, terms.cols() + 2);
    A << terms, nuisances.columns;
    Eigen::MatrixXd H = A.transpose() * normal.G * A;
    H.bottomRightCorner(2, 2).diagonal() += nuisances.precision;
    return A * H.ldlt().solve(A.transpose() * normal.c);
  }
  /// Squares and priors of figures that consist of nuisances z and terms.
  double objective(const Eigen::MatrixXd& terms) const {
    Eigen::MatrixXd A(6, terms.cols() + 2);
    A << terms, nuisances.columns;
    Eigen::MatrixXd H = A.transpose() * normal.G * A;
    H.bottomRightCorner(2, 2).diagonal() += nuisances.precision;
    const Eigen::VectorXd b = A.transpose() * normal.c;
    return normal.yy - b.dot(H.ldlt().solve(b));
  }
};

DriveTerm term_of(const Eigen::MatrixXd& columns, double low = -kFree, double high = kFree) {
  DriveTerm out;
  out.columns = columns;
  for (Eigen::Index i = 0; i < columns.cols(); ++i) {
    out.parameters.push_back("x" + std::to_string(i)), out.units.push_back("-");
    out.low.push_back(low), out.high.push_back(high);
  }
  return out;
}

TEST(Normal, LosesWhatIsLeft) {
  const Drawn d(1);
  Random random(2);
  for (int k = 0; k < 5; ++k) {
    const Eigen::VectorXd figures = drawn(random, 6, 1);
    EXPECT_NEAR(d.normal.loss(figures), (d.y - d.X * figures).squaredNorm(), 1e-9);
  }
  Normal twice(6);
  twice.add(d.normal), twice.add(d.normal, 0.5);
  const Eigen::VectorXd figures = drawn(random, 6, 1);
  EXPECT_NEAR(twice.loss(figures), 1.5 * d.normal.loss(figures), 1e-9);
}

TEST(Eliminated, IsTheSolutionInOnePiece) {
  for (std::uint64_t seed = 1; seed < 6; ++seed) {
    const Drawn d(seed);
    Random random(seed, 7);
    const DriveTerm a = term_of(drawn(random, 6, 1)), b = term_of(drawn(random, 6, 2));
    Eigen::MatrixXd both(6, 3);
    both << a.columns, b.columns;
    const Eliminated eliminated(d.normal, d.nuisances);
    EXPECT_LT((eliminated.fit({}).figures - d.in_one_piece(Eigen::MatrixXd(6, 0))).norm(), 1e-9);
    EXPECT_LT((eliminated.fit({&a}).figures - d.in_one_piece(a.columns)).norm(), 1e-8);
    EXPECT_LT((eliminated.fit({&a, &b}).figures - d.in_one_piece(both)).norm(), 1e-8);
    EXPECT_EQ(eliminated.fit({&a, &b}).x.size(), 3);
  }
}

TEST(Eliminated, GainsWhatTheObjectiveFallsBy) {
  const Drawn d(4);
  Random random(8);
  const DriveTerm a = term_of(drawn(random, 6, 2));
  const Eliminated eliminated(d.normal, d.nuisances);
  EXPECT_EQ(eliminated.fit({}).gain, 0.0);
  EXPECT_NEAR(eliminated.fit({&a}).gain,
              d.objective(Eigen::MatrixXd(6, 0)) - d.objective(a.columns), 1e-8);
}

TEST(Eliminated, KeepsCoefficientsWithinTheirBounds) {
  const Drawn d(5);
  Random random(9);
  const Eigen::MatrixXd column = drawn(random, 6, 1);
  const Eliminated eliminated(d.normal, d.nuisances);
  const DriveTerm free = term_of(column);
  const double x = eliminated.fit({&free}).x[0];
  ASSERT_NE(x, 0.0);
  const DriveTerm half = term_of(column, -0.5 * std::abs(x), 0.5 * std::abs(x));
  EXPECT_NEAR(eliminated.fit({&half}).x[0], 0.5 * x, 1e-9);
  const DriveTerm none = term_of(column, x > 0 ? -1.0 : 0.0, x > 0 ? 0.0 : 1.0);
  EXPECT_NEAR(eliminated.fit({&none}).x[0], 0.0, 1e-9);
  EXPECT_GE(eliminated.fit({&free}).gain, eliminated.fit({&half}).gain);
  EXPECT_GE(eliminated.fit({&half}).gain, 0.0);
}

/// Rows of `recordings` recordings of three pieces each, two channels.
DriveRows rows_of(int recordings, std::uint64_t seed) {
  Random random(seed);
  DriveRows out;
  const int each = 30;
  out.X = drawn(random, recordings * 3 * each, 5), out.y = drawn(random, out.X.rows(), 1);
  out.channels = 2;
  for (int r = 0; r < recordings; ++r)
    for (int p = 0; p < 3; ++p)
      for (int k = 0; k < each; ++k) {
        out.recording.push_back(r), out.piece.push_back(p), out.channel.push_back(k % 2);
      }
  return out;
}

Normal sum_of(const std::vector<Normal>& groups) {
  Normal out(5);
  for (const Normal& g : groups) out.add(g);
  return out;
}

TEST(DriveGroups, HoldEveryRowOnceAWay) {
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(5);
  const DriveGroups many = weighed(rows_of(5, 3), none, 3.0);
  ASSERT_EQ(many.by.size(), 2u) << "by recording and by piece";
  EXPECT_EQ(many.by[0].size(), 5u);
  EXPECT_EQ(many.by[1].size(), 3u);
  for (const auto& way : many.by) {
    EXPECT_LT((sum_of(way).G - many.all.G).norm(), 1e-9 * many.all.G.norm());
    EXPECT_LT((sum_of(way).c - many.all.c).norm(), 1e-9 * many.all.c.norm());
    EXPECT_NEAR(sum_of(way).yy, many.all.yy, 1e-9 * many.all.yy);
  }
  const DriveGroups few = weighed(rows_of(2, 3), none, 3.0);
  ASSERT_EQ(few.by.size(), 1u) << "two recordings are too few to leave one out";
  EXPECT_EQ(few.by[0].size(), 3u);
}

TEST(DriveGroups, ARowThatStandsOutWeighsLess) {
  DriveRows rows = rows_of(4, 4);
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(5);
  const double before = weighed(rows, none, 3.0).all.yy;
  rows.y[10] = 1e3;
  const double after = weighed(rows, none, 3.0).all.yy;
  // weight 3 / size: what it adds grows as its size and not as the square
  EXPECT_LT(after - before, 3.0 * 1.1e3);
  EXPECT_GT(after - before, 1e3);
}

TEST(DriveGroups, AChannelIsMeasuredByItsOwnScatter) {
  DriveRows rows = rows_of(4, 5);
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(5);
  const DriveGroups before = weighed(rows, none, 3.0);
  for (Eigen::Index i = 0; i < rows.y.size(); ++i)
    if (rows.channel[static_cast<std::size_t>(i)] == 1) rows.y[i] *= 50.0, rows.X.row(i) *= 50.0;
  const DriveGroups after = weighed(rows, none, 3.0);
  EXPECT_LT((after.all.G - before.all.G).norm(), 1e-9 * before.all.G.norm());
  EXPECT_NEAR(after.all.yy, before.all.yy, 1e-9 * before.all.yy);
}

TEST(LeftByChannel, IsTheRmsOfEach) {
  DriveRows rows = rows_of(1, 6);
  const Eigen::VectorXd figures = Eigen::VectorXd::Constant(5, 0.3);
  const Eigen::VectorXd left = rows.y - rows.X * figures;
  double squares[2] = {0.0, 0.0};
  for (Eigen::Index i = 0; i < left.size(); ++i) squares[i % 2] += left[i] * left[i];
  const std::vector<double> found = left_by_channel(rows, figures, 1e9);
  ASSERT_EQ(found.size(), 2u);
  for (std::size_t c = 0; c < 2; ++c) EXPECT_NEAR(found[c], std::sqrt(squares[c] / 45.0), 1e-12);
}

TEST(Eliminated, ATermIsAsSureAsTheRowsAreOfItsOwnFigures) {
  // two figures that rows see apart, each with a nominal model's tolerance, which is wide
  Normal normal(2);
  normal.G = Eigen::Vector2d(400.0, 100.0).asDiagonal();
  DriveNuisances off;
  off.columns = Eigen::Matrix2d::Identity(), off.precision = Eigen::Vector2d(1e-4, 1e-4);
  const DriveTerm one = term_of(Eigen::Vector2d(1.0, 0.0));
  const DriveTerm both = term_of(Eigen::Vector2d(1.0, 1.0));
  const Eliminated eliminated(normal, off);
  EXPECT_NEAR(eliminated.deviations({&one})[0], 1.0 / std::sqrt(400.0), 1e-6);
  // the mean of the two
  EXPECT_NEAR(eliminated.deviations({&both})[0], 0.5 * std::sqrt(1.0 / 400.0 + 1.0 / 100.0), 1e-4);
}

TEST(Eliminated, ATermIsLessSureWhereAnotherFigureReadsLikeIt) {
  // rows see the sum of two figures; the second may be off by 0.2, and is none of the term's
  Normal normal(2);
  normal.G.setConstant(400.0);
  DriveNuisances off;
  off.columns = Eigen::Vector2d(0.0, 1.0), off.precision = Eigen::VectorXd::Constant(1, 25.0);
  const DriveTerm one = term_of(Eigen::Vector2d(1.0, 0.0));
  EXPECT_NEAR(Eliminated(normal, off).deviations({&one})[0], std::hypot(0.2, 0.05), 1e-9);
}

}  // namespace
}  // namespace sanso::diagnose
