// Least squares of what leans: a vector of the world's, and one of each part that turns with the
// robot. Of every reading, turn the rotation by its heading:
//
//   lean = world + turn body[part] + noise,  numbers x = (world, body[0], body[1], ...)
//
// Where all headings are alike the two are one; a weak prior then says that each is known as little
// as it is, instead of sharing the lean among them.
#include "tools/diagnose/wholebody/lean.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "tools/diagnose/stats/random.h"
#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/significance.h"

namespace sanso::diagnose {

Level::Level(const V3& upwards) : up(upwards) {
  const V3 ahead = std::abs(up.x()) < 0.9 ? V3::UnitX() : V3::UnitY();
  x = (ahead - up.dot(ahead) * up).normalized(), y = up.cross(x);
}

double Level::heading(const M3& R_world_base) const {
  const V2 ahead = lean(R_world_base.col(0));
  return std::atan2(ahead[1], ahead[0]);
}

void Leans::add(const V2& lean, double heading, const std::string& part, std::size_t recording,
                std::size_t piece, std::size_t group) {
  const auto at = std::find(parts_.begin(), parts_.end(), part);
  const auto number = static_cast<std::size_t>(at - parts_.begin());
  if (at == parts_.end()) parts_.push_back(part);
  if (cells_.empty() || cells_.back().recording != recording || cells_.back().piece != piece ||
      cells_.back().part != number)
    cells_.push_back({recording, piece, group, number});
  Cell& c = cells_.back();
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(heading).toRotationMatrix();
  c.rows += 1.0, c.squares += lean.squaredNorm();
  c.world += lean, c.body += turn.transpose() * lean, c.turn += turn;
}

namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// Normal equations of a few readings: N x = c, with the sum of squares for the error of any x.
struct Sums {
  Matrix N;
  Vector c;
  double squares = 0.0, rows = 0.0;
  explicit Sums(long numbers) : N(Matrix::Zero(numbers, numbers)), c(Vector::Zero(numbers)) {}
  void add(const Sums& other, double times = 1.0) {
    N += times * other.N, c += times * other.c;
    squares += times * other.squares, rows += times * other.rows;
  }
  double error(const Vector& x) const {
    return std::max(0.0, squares - 2.0 * x.dot(c) + x.dot(N * x));
  }
};

/// A piece of readings with what resampling and the hold-out need to know.
struct Piece {
  std::size_t recording = 0, group = 0;
  bool held_out = false;
  Sums sums;
  Matrix design;  // sum of the rows' derivatives: 2 x numbers
};

/// Numbers: the world's x and y, then ahead and left of every part.
class LeanProblem {
 public:
  LeanProblem(std::vector<Piece> pieces, long numbers, double wander, double most)
      : pieces_(std::move(pieces)), numbers_(numbers), wander_(wander), most_(most) {}

  enum class Using { all, world, body };

  /// Least squares with the weak prior; `take` says how often a piece counts. Numbers that are not
  /// in use are zero.
  ///
  ///   (N + lambda I) x = c,  lambda = prior
  Vector solved(Using which, const std::function<double(const Piece&)>& take) const {
    Sums sums(numbers_);
    for (const Piece& p : pieces_) {
      const double times = take(p);
      if (times > 0.0) sums.add(p.sums, times);
    }
    return solved(which, sums);
  }
  Vector solved(Using which, const Sums& sums) const {
    Matrix N = sums.N;
    Vector c = sums.c;
    N.diagonal().array() += prior(sums);
    for (long i = 0; i < numbers_; ++i) {
      if (which == Using::all || (i < 2) == (which == Using::world)) continue;
      N.row(i).setZero(), N.col(i).setZero(), N(i, i) = 1.0, c[i] = 0.0;
    }
    return N.ldlt().solve(c);
  }

  /// What wandering between recordings and the prior leave unknown, beside chance. Covariance of
  /// the numbers when every recording has a lean of its own of deviation `wander`, and the numbers
  /// themselves are of size `most`, S the summed design of a recording:
  ///
  ///   A^-1 (lambda^2 most^2 I + wander^2 sum over recordings of S'S) A^-1,  A = N + lambda I
  Matrix unknown(Using which) const {
    Sums sums(numbers_);
    std::map<std::size_t, Matrix> by_recording;
    for (const Piece& p : pieces_) {
      sums.add(p.sums);
      auto& S = by_recording.try_emplace(p.recording, Matrix::Zero(2, numbers_)).first->second;
      S += p.design;
    }
    const double lambda = prior(sums);
    Matrix middle = lambda * lambda * most_ * most_ * Matrix::Identity(numbers_, numbers_);
    for (const auto& entry : by_recording)
      middle += wander_ * wander_ * entry.second.transpose() * entry.second;
    Matrix N = sums.N + lambda * Matrix::Identity(numbers_, numbers_);
    for (long i = 0; i < numbers_; ++i) {
      if (which == Using::all || (i < 2) == (which == Using::world)) continue;
      N.row(i).setZero(), N.col(i).setZero(), N(i, i) = 1.0;
      middle.row(i).setZero(), middle.col(i).setZero();
    }
    const Matrix inverse = N.ldlt().solve(Matrix::Identity(numbers_, numbers_));
    return inverse * middle * inverse;
  }

  const std::vector<Piece>& pieces() const { return pieces_; }
  long numbers() const { return numbers_; }

 private:
  /// A millionth of the rows: nothing beside headings that differ at all.
  double prior(const Sums& sums) const { return 1e-6 * std::max(sums.rows, 1.0); }

  std::vector<Piece> pieces_;
  long numbers_;
  double wander_, most_;
};

/// Takes the mean over parts out of the numbers of the robot's own.
Matrix means(long numbers) {
  Matrix M = Matrix::Zero(2, numbers);
  const double parts = static_cast<double>(numbers - 2) / 2.0;
  for (long i = 2; i < numbers; ++i) M(i % 2, i) = 1.0 / parts;
  return M;
}
Matrix first_two(long numbers) {
  Matrix M = Matrix::Zero(2, numbers);
  M(0, 0) = M(1, 1) = 1.0;
  return M;
}

/// Covariance of the numbers when n groups are resampled: n / (n - 1) mean of off off', off what
/// a draw's numbers differ by from those of all.
Matrix scatter(const LeanProblem& problem, LeanProblem::Using which, const Chance& chance) {
  std::map<std::size_t, Sums> by_group;
  for (const Piece& p : problem.pieces())
    by_group.try_emplace(p.group, problem.numbers()).first->second.add(p.sums);
  std::vector<const Sums*> groups;
  groups.reserve(by_group.size());
  for (const auto& entry : by_group) groups.push_back(&entry.second);
  const std::size_t n = groups.size();
  Random random(chance.seed, 41);
  const Vector whole = problem.solved(which, [](const Piece&) { return 1.0; });
  Matrix out = Matrix::Zero(problem.numbers(), problem.numbers());
  for (int d = 0; d < chance.whole.draws; ++d) {
    Sums drawn(problem.numbers());
    for (std::size_t k = 0; k < n; ++k) drawn.add(*groups[random.below(n)]);
    const Vector off = problem.solved(which, drawn) - whole;
    out += off * off.transpose();
  }
  // few groups spread too little
  const auto drawn_groups = static_cast<double>(n);
  return out * (drawn_groups / std::max(1.0, drawn_groups - 1.0) / chance.whole.draws);
}

/// Size of a vector with its deviation, and what it adds on the pieces held out to `without`:
/// gain = 1 - error(with) / error(without), both fitted to the others (without: no lean at all).
Measured sized(const V2& value, const Matrix& covariance, const LeanProblem& problem,
               LeanProblem::Using with, std::optional<LeanProblem::Using> without,
               const Chance& chance) {
  Measured m;
  m.value = value.norm(), m.sigma = std::sqrt(covariance.trace());
  m.low = std::max(0.0, m.value - kNormal95 * m.sigma), m.high = m.value + kNormal95 * m.sigma;
  const auto fitted = [](const Piece& p) { return p.held_out ? 0.0 : 1.0; };
  const Vector x = problem.solved(with, fitted);
  const Vector other =
      without ? problem.solved(*without, fitted) : Vector(Vector::Zero(problem.numbers()));
  std::vector<double> removed;
  double before = 0.0, after = 0.0, rows = 0.0;
  for (const Piece& p : problem.pieces()) {
    if (!p.held_out) continue;
    const double b = p.sums.error(other), a = p.sums.error(x);
    removed.push_back(b - a), before += b, after += a, rows += p.sums.rows;
  }
  m.groups = removed.size();
  if (rows <= 0.0 || before <= 0.0) return m;
  m.before = std::sqrt(before / rows), m.after = std::sqrt(after / rows);
  m.gain = 1.0 - after / before;
  m.gain_low = moving_block_lower_bound(removed, chance.decisions.gain_level,
                                        chance.decisions.gain_draws, Random(chance.seed, 42)) /
               before;
  return m;
}

/// What recordings have beside what they share, half of them at least (one in which the robot tips
/// onto an edge tells no floor), and what the fitted pieces of each say of its others. With left =
/// sum over a piece of (lean - design x) and mean that of a recording's fitted pieces, a held-out
/// piece of `rows` loses 2 mean'left - rows |mean|^2 of its squared error.
Measured between(const LeanProblem& problem, const Vector& x, double wander, const Chance& chance) {
  struct Own {
    V2 all = V2::Zero(), fitted = V2::Zero();
    double rows = 0.0, fitted_rows = 0.0;
  };
  std::map<int, Own> own;
  for (const Piece& p : problem.pieces()) {
    Own& o = own[p.recording];
    const V2 left = p.sums.c.head<2>() - p.design * x;
    o.all += left, o.rows += p.sums.rows;
    if (!p.held_out) o.fitted += left, o.fitted_rows += p.sums.rows;
  }
  Measured m;
  double before = 0.0;
  std::vector<double> sizes;
  for (const auto& entry : own) sizes.push_back((entry.second.all / entry.second.rows).norm());
  std::vector<double> removed;
  for (const Piece& p : problem.pieces()) {
    const Own& o = own[p.recording];
    if (!p.held_out || o.fitted_rows <= 0.0) continue;
    const V2 left = p.sums.c.head<2>() - p.design * x, mean = o.fitted / o.fitted_rows;
    removed.push_back(2.0 * mean.dot(left) - p.sums.rows * mean.squaredNorm());
    before += p.sums.error(x);
  }
  m.groups = own.size();
  m.value = median(sizes);
  m.sigma = wander;
  m.low = std::max(0.0, m.value - kNormal95 * wander), m.high = m.value + kNormal95 * wander;
  if (before > 0.0 && !removed.empty())
    m.gain_low = moving_block_lower_bound(removed, chance.decisions.gain_level,
                                          chance.decisions.gain_draws, Random(chance.seed, 43)) /
                 before;
  return m;
}

}  // namespace

std::optional<LeanFit> LeanFit::of(const Leans& leans, double wander, const Chance& chance) {
  const long numbers = 2 + 2 * static_cast<long>(leans.parts_.size());
  std::vector<Piece> pieces;
  std::vector<std::size_t> groups;
  for (const Leans::Cell& c : leans.cells_) {
    // N = sum of D'D,  c = sum of D'lean,  D = (I, turn at the part's place) of a reading
    Piece p{c.recording, c.group, c.piece % 3 == 2, Sums(numbers), Matrix::Zero(2, numbers)};
    const long at = 2 + 2 * static_cast<long>(c.part);
    p.design.leftCols<2>() = c.rows * Eigen::Matrix2d::Identity();
    p.design.middleCols<2>(at) = c.turn;
    p.sums.N.topLeftCorner<2, 2>() = c.rows * Eigen::Matrix2d::Identity();
    p.sums.N.block<2, 2>(at, at) = c.rows * Eigen::Matrix2d::Identity();
    p.sums.N.block<2, 2>(0, at) = c.turn, p.sums.N.block<2, 2>(at, 0) = c.turn.transpose();
    p.sums.c.head<2>() = c.world, p.sums.c.segment<2>(at) = c.body;
    p.sums.squares = c.squares, p.sums.rows = c.rows;
    pieces.push_back(std::move(p)), groups.push_back(c.group);
  }
  std::sort(groups.begin(), groups.end());
  groups.erase(std::unique(groups.begin(), groups.end()), groups.end());
  if (groups.size() < static_cast<std::size_t>(chance.whole.least_groups)) return std::nullopt;
  const LeanProblem problem(std::move(pieces), numbers, wander, chance.whole.leans);
  using Using = LeanProblem::Using;
  const auto every = [](const Piece&) { return 1.0; };
  const Vector x = problem.solved(Using::all, every), one = problem.solved(Using::world, every);
  const Matrix C = scatter(problem, Using::all, chance) + problem.unknown(Using::all);
  const Matrix C_one = scatter(problem, Using::world, chance) + problem.unknown(Using::world);
  // in_world = W x,  in_body = B x, with the covariances W C W' and B C B'
  const Matrix W = first_two(numbers), B = means(numbers);
  LeanFit out;
  out.in_world = W * x, out.in_body = B * x, out.alike = W * one;
  out.world = sized(out.in_world, W * C * W.transpose(), problem, Using::all, Using::body, chance);
  out.body = sized(out.in_body, B * C * B.transpose(), problem, Using::all, Using::world, chance);
  out.together =
      sized(out.alike, W * C_one * W.transpose(), problem, Using::world, std::nullopt, chance);
  out.apart = between(problem, x, wander, chance);
  return out;
}

}  // namespace sanso::diagnose
