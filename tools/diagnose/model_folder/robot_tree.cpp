// Bodies behind fixed joints are added to the body that carries them (parallel-axis theorem).
#include "tools/diagnose/model_folder/robot_tree.h"

#include <cmath>

namespace sanso::diagnose {
namespace {

/// mass * (|r|^2 1 - r r'): inertia of a point mass at r.
Mat3 point_inertia(double mass, const Vec3& r) {
  const double rr = r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
  Mat3 I{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) I[3 * i + j] = mass * ((i == j ? rr : 0.0) - r[i] * r[j]);
  }
  return I;
}

Vec3 minus(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

}  // namespace

Vec3 operator+(const Vec3& a, const Vec3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }

Vec3 rotated(const Mat3& R, const Vec3& v) {
  return {R[0] * v[0] + R[1] * v[1] + R[2] * v[2], R[3] * v[0] + R[4] * v[1] + R[5] * v[2],
          R[6] * v[0] + R[7] * v[1] + R[8] * v[2]};
}

Mat3 product(const Mat3& A, const Mat3& B) {
  Mat3 C{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t k = 0; k < 3; ++k) C[3 * i + j] += A[3 * i + k] * B[3 * k + j];
    }
  }
  return C;
}

void add_body(BodyInertia& whole, const BodyInertia& part) {
  const double mass = whole.mass + part.mass;
  if (mass <= 0.0) return;
  Vec3 com{};
  for (std::size_t k = 0; k < 3; ++k)
    com[k] = (whole.mass * whole.com[k] + part.mass * part.com[k]) / mass;
  // parallel axes: each body's inertia moves to the common centre of mass
  const Mat3 shift_whole = point_inertia(whole.mass, minus(whole.com, com));
  const Mat3 shift_part = point_inertia(part.mass, minus(part.com, com));
  for (std::size_t k = 0; k < 9; ++k)
    whole.about_com[k] += part.about_com[k] + shift_whole[k] + shift_part[k];
  whole.mass = mass;
  whole.com = com;
}

BodyInertia moved(const BodyInertia& body, const Mat3& R, const Vec3& p) {
  const Mat3 R_transposed{R[0], R[3], R[6], R[1], R[4], R[7], R[2], R[5], R[8]};
  return {body.mass, p + rotated(R, body.com), product(product(R, body.about_com), R_transposed)};
}

int RobotTree::index_of(const std::string& joint) const {
  for (std::size_t k = 0; k < joints.size(); ++k) {
    if (joints[k].name == joint) return static_cast<int>(k);
  }
  return -1;
}

}  // namespace sanso::diagnose
