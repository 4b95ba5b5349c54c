// The OP3 link by link, from the same tables that the specialised dynamics are made of.
#include "tests/oracle/op3_tree.h"

namespace sanso::model {
namespace {

LinkInertia link_of(const BodyInertia& b) {
  const double* I = b.inertia;
  LinkInertia link{b.mass, Vec3(b.com[0], b.com[1], b.com[2]), Mat3()};
  link.about_com << I[0], I[1], I[2], I[1], I[3], I[4], I[2], I[4], I[5];
  return link;
}

}  // namespace

Tree op3_tree(const ModelParameters& theta) {
  Tree tree;
  tree.floating = true;
  tree.base = link_of(theta.body[0]);
  for (int j = 0; j < kNumJoints; ++j) {
    const JointGeometry& g = kOp3Joints[j];
    TreeJoint joint;
    joint.parent = j % 6 == 0 ? -1 : j - 1;
    joint.p_parent_link0 = Vec3(g.origin[0], g.origin[1], g.origin[2]);
    joint.axis = g.sign * Vec3::Unit(g.axis);
    joint.link = link_of(theta.body[j + 1]);
    joint.armature = theta.servo[j].armature;
    tree.joints.try_push(joint);  // 12 of kMaxTreeJoints
  }
  return tree;
}

}  // namespace sanso::model
