// Physics of the emulated robot: MuJoCo's rigid bodies and contacts, and a gear train of our own
// for every servo.
// Fixed step of 0.5 ms; the same calls give the same bits.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "tools/plant/gear_train.h"
#include "tools/plant/world.h"

namespace sanso::plant {

inline constexpr int kNumServos = 20;  // index = servo id - 1

struct BaseMotion {
  Vec3 p_world_base{};
  Quat quat_world_base{1, 0, 0, 0};
  Vec3 v_base_in_world{};
  Vec3 w_base_in_base{};
};

struct FootLoad {
  Vec3 force_in_world{};  // ground on foot, N
  int contacts = 0;       // touching sole points
  // m, of the lowest sole point from the floor, plate or profile below it; negative: pressed in
  double clearance_m = 0.0;
};

class Plant {
 public:
  explicit Plant(const World& world);
  ~Plant();
  Plant(Plant&&) noexcept;
  Plant& operator=(Plant&&) noexcept;

  /// Bridge of a servo: duty -1..1, or open.
  void set_duty(int servo, double duty);
  void set_coast(int servo);
  /// Resistance of a servo's winding, share of that at 25 degrees.
  void set_winding(int servo, double resistance_share);
  /// Charge that the battery has given so far [Ah].
  void set_used_charge(double used_Ah);
  double used_charge() const;
  /// Overrides the supply (brown-out); a negative value gives it back to the battery.
  void override_supply(double volt);

  /// One step of kPhysicsStep_s.
  void step();
  std::int64_t steps() const;

  /// The ground below (x, y).
  struct Surface {
    double z = 0;  // m
    Vec3 normal{0, 0, 1};
  };
  /// World axes; the normal has length 1.
  Surface ground(double x_m, double y_m) const;

  /// At rest with these joint angles [rad], feet flat on the ground at (x, y), heading yaw.
  void place(const std::array<double, kNumServos>& q, double x_m, double y_m, double yaw_rad);
  /// Keeps the base where it is now, until false.
  void hold(bool held);
  bool held() const;

  /// Wrench at the torso's origin, world axes, until changed.
  void set_push(const Vec3& force_in_world, const Vec3& torque_in_world);

  /// Where the torso really is and how it moves (plant.h: BaseMotion).
  BaseMotion base() const;
  /// By servo id - 1: rad and rad/s of the link, behind backlash and compliance.
  double link_angle(int servo) const;
  double link_rate(int servo) const;
  const GearTrain& gear(int servo) const;
  /// As the servos have it, under their load.
  double supply_V() const;
  std::array<FootLoad, 2> feet() const;  // right, left
  int other_contacts() const;            // contacts of anything but feet

  /// Of the whole robot with what it carries; the following serve the laws of physics in tests.
  double mass_kg() const;
  Vec3 center_of_mass() const;   // world
  Vec3 linear_momentum() const;  // world
  // about the centre of mass, world axes; links only, without rotors
  Vec3 angular_momentum() const;
  double mechanical_energy_J() const;  // links: kinetic and potential

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sanso::plant
