// Masses and forces on links, and what no library names: how to hide it, and what the answer says.
#include <cmath>

#include "tools/conceal/hideable_families.h"

namespace sanso::conceal {

using plant::operator+;

// The link itself and what is fixed to it.
std::vector<Hideable> mass_effects() {
  return {
      on_link("link_mass", 0.15, 0.5,
              [](WorldTruth& w, int at, double s, Random& r) {
                s *= sign(r);
                LinkSpec& l = link(w, at);
                l.mass *= 1 + s;
                for (double& i : l.inertia) i *= 1 + s;
                return Parameters{{"share", s}};
              }),
      on_link("link_com", 0.01, 0.03,
              [](WorldTruth& w, int at, double s, Random& r) {
                const double angle = r.uniform(0, 2 * plant::kPi);
                const Vec3 shift{s * std::cos(angle), 0, s * std::sin(angle)};
                link(w, at).com = link(w, at).com + shift;
                return Parameters{{"x", shift[0]}, {"y", 0}, {"z", shift[2]}};
              }),
      on_link("link_inertia", 0.3, 0.6,
              [](WorldTruth& w, int at, double s, Random&) {
                add_axis_inertia(link(w, at), s);
                return Parameters{{"share", s}};
              }),
      on_link("payload", 0.1, 0.8,
              [](WorldTruth& w, int at, double s, Random& r) {
                w.payload = {at, s, r.uniform(5, 12)};
                const Vec3& p = link(w, at).payload_at;
                return Parameters{
                    {"mass", s}, {"x", p[0]}, {"y", p[1]}, {"z", p[2]}, {"from", w.payload.from_s}};
              }),
      on_link("external_push", 3, 50,
              [](WorldTruth& w, int at, double s, Random& r) {
                const double from = r.uniform(3, 15), duration = r.uniform(0.1, 0.4);
                const Vec3 force{s * sign(r), 0, 0};
                w.push = {at, force, from, from + duration};
                return Parameters{
                    {"x", force[0]}, {"y", 0}, {"z", 0}, {"from", from}, {"duration", duration}};
              }),
      on_link("tether", 1, 15,
              [](WorldTruth& w, int at, double s, Random& r) {
                const double angle = r.uniform(0, 2 * plant::kPi);
                w.tether = {at, {s * std::cos(angle), 0, s * std::sin(angle)}, -1e9, 1e9};
                return Parameters{{"x", w.tether.force[0]}, {"y", 0}, {"z", w.tether.force[2]}};
              }),
  };
}

// Physics that the library has no name for.
std::vector<Hideable> outside_effects() {
  return {
      outside("cubic_spring", 1.0, 10,
              [](WorldTruth& w, int at, double s, Random&) { joint(w, at).cubic_spring = s; }),
      outside("angle_damping", 0.5, 4,
              [](WorldTruth& w, int at, double s, Random&) { joint(w, at).angle_damping = s; }),
      outside("gain_softening", 1.0, 12,
              [](WorldTruth& w, int at, double s, Random&) { joint(w, at).gain_softening = s; }),
      outside("creep_spring", 0.5, 4,
              [](WorldTruth& w, int at, double s, Random& r) {
                joint(w, at).creep_spring = s;
                joint(w, at).creep_time_s = r.uniform(0.3, 1.5);
              }),
      outside("joint_coupling", 0.1, 1.0,
              [](WorldTruth& w, int at, double s, Random& r) {
                const int n = w.robot.size();
                if (n < 2) {
                  joint(w, at).cubic_spring = 4 * s;  // one joint has nothing to be coupled with
                  return;
                }
                w.coupling = {
                    (at + 1 + static_cast<int>(r.bits() % static_cast<std::uint64_t>(n - 1))) % n,
                    at, s};
              }),
  };
}

}  // namespace sanso::conceal
