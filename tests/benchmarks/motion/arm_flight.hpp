#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/mechanism/mechanism.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"
#include "touchstone/tests/support/degree.hpp"

namespace touchstone {

/// What the arm does: see arm_step_benchmark.cpp.
enum class ArmPhase { free, near, sliding };

struct ArmCase {
  std::string backend;
  ArmPhase phase;
  double rate;             ///< [frames a second]
  std::uint64_t seed = 0;  ///< of a drawn motion; 0: the even one
};

/// Numbers that are the same with every standard library.
class Drawing {
 public:
  explicit Drawing(std::uint64_t seed) : random_(seed) {}
  double real(double low, double high) {
    return low + (high - low) * (static_cast<double>(random_() >> 11) * 0x1p-53);
  }

 private:
  std::mt19937_64 random_;
};

/// To and fro, never faster than `rate`.
struct Swing {
  double rate = 0.0, period = 20.0, phase = 0.0;  // [rad/s], [s], [rad]

  double at(double time) const;
};

/// The arm over its scene: shoulder up, elbow down, end effector level, reaching out along x.
class ArmFlight {
 public:
  /// One of the scene's boxes, which stand still.
  struct Block {
    Hexahedron solid;
    Pose X_WS;
  };

  explicit ArmFlight(const ArmCase& wanted);

  /// A frame of the case's motion.
  FrameReport step();
  /// A frame to these joint values in its place.
  FrameReport step_to(std::span<const double> joints);

  int frames_until_settled() const { return static_cast<int>(4 * case_.rate); }
  const Mechanism& arm() const { return *arm_; }
  std::span<const Block> blocks() const { return blocks_; }
  /// The last frame's command, and where the arm is [rad].
  std::span<const double> commanded() const { return joints_; }
  std::span<const double> actual() const { return world_->joint_values(handle_); }
  /// How far the joints are from their command [rad].
  double behind() const;

 private:
  void choose_motion();
  double lowest_point() const;
  void add_floor(double top);
  void add_others();
  void add(const std::string& name, const Vector3& size, const Pose& X_WS);

  ArmCase case_;
  Drawing drawing_;
  std::array<Swing, 7> swings_;
  double press_ = 0.6 * kDegree;
  std::shared_ptr<const Mechanism> arm_;
  std::vector<double> start_ = {0, 0, -30 * kDegree, 60 * kDegree, -30 * kDegree, 0, 0}, joints_;
  std::vector<Block> blocks_;
  std::unique_ptr<ContactWorld> world_;
  MechanismHandle handle_;
  int frame_ = 0;
};

}  // namespace touchstone
