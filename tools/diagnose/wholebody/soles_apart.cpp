// With n the normal of a sole in base axes and e two axes across both:
//
//   lean = e'(n_one - n_other) = sum over j of zero_j d e'(n_one - n_other) / d q_j
#include "tools/diagnose/wholebody/soles_apart.h"

#include "tools/diagnose/wholebody/contacts.h"
#include "tools/diagnose/wholebody/lean.h"

namespace sanso::diagnose {

std::optional<SolesApart> soles_apart(const WholeBody& body, FloatingTree& tree,
                                      const FloatingMotion& motion, const FootForce& one,
                                      const FootForce& other) {
  constexpr double kStep = 1e-4;  // rad
  const auto a = sole_normal(body, one.joint, one.link);
  const auto b = sole_normal(body, other.joint, other.link);
  if (!a || !b) return std::nullopt;
  tree.set(motion);
  const auto normal_of_one = [&]() -> V3 { return tree.rotation(one.joint) * *a; };
  const auto normal_of_other = [&]() -> V3 { return tree.rotation(other.joint) * *b; };
  const Level level((normal_of_one() + normal_of_other()).normalized());
  const V3 now = normal_of_one() - normal_of_other();
  SolesApart out;
  out.lean = level.lean(now);
  out.by_zero.resize(2, motion.q.size());
  FloatingMotion moved = motion;
  for (Eigen::Index j = 0; j < motion.q.size(); ++j) {
    moved.q[j] += kStep;
    tree.set(moved);
    out.by_zero.col(j) = level.lean((normal_of_one() - normal_of_other() - now) / kStep);
    moved.q[j] -= kStep;
  }
  tree.set(motion);
  return out;
}

}  // namespace sanso::diagnose
