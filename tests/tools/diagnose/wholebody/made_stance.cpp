// Apart from its header: the decomposition costs a compiler seconds, once instead of in every test.
#include "tests/tools/diagnose/wholebody/made_stance.h"

namespace sanso::diagnose::test {

Eigen::VectorXd torques_of(const FloatingTree& tree, const std::vector<int>& soles, double t,
                           const Eigen::VectorXd& given) {
  const Eigen::VectorXd needed = tree.needed() - given;
  Eigen::MatrixXd J(needed.size(), 6 * static_cast<Eigen::Index>(soles.size()));
  for (std::size_t s = 0; s < soles.size(); ++s)
    for (Eigen::Index i = 0; i < 3; ++i) {
      const auto at = 6 * static_cast<Eigen::Index>(s) + i;
      J.col(at) = tree.of_wrench(soles[s], V3::Unit(i), V3::Zero());
      J.col(at + 3) = tree.of_wrench(soles[s], V3::Zero(), V3::Unit(i));
    }
  const Eigen::MatrixXd on_base = J.topRows(6);
  const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solve(on_base);
  Eigen::VectorXd wanted(J.cols());
  for (Eigen::Index i = 0; i < wanted.size(); ++i)
    wanted[i] = (i % 6 < 3 ? 3.0 : 0.3) * std::sin((0.8 + 0.1 * static_cast<double>(i)) * t);
  const Eigen::VectorXd push =
      wanted + solve.solve(Eigen::VectorXd(needed.head(6) - on_base * wanted));
  return (needed - J * push).tail(needed.size() - 6);
}

}  // namespace sanso::diagnose::test
