#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/mechanism/mechanism.hpp"
#include "touchstone/contact_core/motion/mass_metric.hpp"

namespace touchstone {

/// How joint rates are found. Rows for turns are weighed with `length`, so that the Jacobian's singular
/// values are lengths [m] (exactly so where all joints turn).
struct ResolvedRateSettings {
  double length = 1.0;  ///< a turn of 1 rad counts like this displacement [m], > 0
  /// Damping sets in where the least singular value's bound (see ResolvedRate) is below this [m], >= 0.
  double damped_below = 0.1;
  double damping = 0.05;  ///< lambda at a singularity [m], > 0
};

/// Resolved-rate control (Whitney 1969) of one link by damped least squares (Wampler 1986, Nakamura and
/// Hanafusa 1986): the joint rates J^T (J J^T + lambda^2 1)^-1 v for the velocity v of a point of the link.
/// Of all rates that give v these are the smallest; damped, they give less than v rather than grow without
/// bound.
///
/// lambda^2 = damping^2 (1 - (s / damped_below)^2) for s < damped_below, else 0, with s^2 = 1 / trace((J
/// J^T)^-1): between the square of the least singular value and a sixth of it.
///
/// Holds scratch, one a thread; nothing allocates after construction. Keeps a reference.
class ResolvedRate {
 public:
  /// @param held_values joints of the link's chain that do not move; values off the chain are ignored.
  /// @throws InputError: a setting out of range, a link that no joint moves, held ones left out.
  ResolvedRate(const Mechanism& mechanism, std::uint32_t link, const ResolvedRateSettings& settings = {},
               std::span<const std::uint32_t> held_values = {});

  /// The result of solve(), and how far it missed its command.
  struct Outcome {
    /// All joint rates were scaled down to this share, so that each is within its joint's limit; 1: none was.
    double scale = 1.0;
    double lambda = 0.0;  ///< [m]
    /// The velocity that the rates give, less the commanded one: undamped and unscaled it is 0 to rounding.
    Twist error;
  };

  /// @param X_WL as from Mechanism::link_poses. @param wanted of the point p_W (fixed in the link).
  /// @param rates value_count() of them; 0 for joints that do not move the link or are held [rad/s, m/s].
  Outcome solve(std::span<const Pose> X_WL, const Vector3& p_W, const Twist& wanted,
                std::span<double> rates) noexcept;

  /// How far the link is from a singularity: s as above, of as many singular values as there are joints where
  /// fewer than six move it; 0: singular to rounding [m].
  double regularity(std::span<const Pose> X_WL, const Vector3& p_W) const noexcept;

  /// Column j of the Jacobian: the velocity that the point p_W of the link gets from value j at rate 1; 0 if
  /// it is held.
  Twist column(std::span<const Pose> X_WL, const Vector3& p_W, std::uint32_t value) const noexcept;

  const Mechanism& mechanism() const { return *mechanism_; }
  std::uint32_t link() const { return link_; }

 private:
  const Mechanism* mechanism_;
  std::uint32_t link_;
  ResolvedRateSettings settings_;
  std::vector<Twist> columns_;           // by value; 0 for joints off the chain
  std::vector<std::uint32_t> joint_of_;  // by value; Mechanism::kNone off the chain, and held
};

}  // namespace touchstone
