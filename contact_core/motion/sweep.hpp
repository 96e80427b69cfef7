#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/geometry/vector.hpp"
#include "touchstone/contact_core/motion/path.hpp"

namespace touchstone {

/// An engine's own search for the time at which two moving solids meet, without our advancement: for
/// benchmarks only.
class Sweep {
 public:
  virtual ~Sweep() = default;
  /// The largest turn of a solid over its path that the engine follows [rad]; beyond it the engine sweeps
  /// another motion. 0: it does not turn solids.
  virtual double most_turn() const noexcept { return kInfinity; }
  /// Untimed. Solids and paths must stay until the next call.
  /// @throws InputError where the engine refuses a solid.
  virtual void set(const Hexahedron& a, const RigidPath& path_a, const Hexahedron& b,
                   const RigidPath& path_b) = 0;
  /// Timed: the share of the path at which the two meet, by the engine's answer; none: they do not.
  /// @throws std::exception as the engine does.
  virtual std::optional<double> impact() = 0;
};

/// How far a solid turns on its path [rad]; exactly 0 where its attitude stays to the bit.
inline double turn_of(const RigidPath& path) { return norm(path.at(0, 0.0).angular_velocity_W); }

/// A sweep and how to make one.
struct SweepEntry {
  std::string name;
  std::string description;  ///< one line, with library and version
  std::string backend;      ///< the narrowphase of the same library
  std::function<std::unique_ptr<Sweep>()> make;
};

}  // namespace touchstone
