#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/motion/path.hpp"

namespace touchstone {

/// An engine's own search for the time at which two moving solids meet, without our advancement: for
/// benchmarks only.
class Sweep {
 public:
  virtual ~Sweep() = default;
  /// False: it sweeps without turning, whatever is asked.
  virtual bool turns() const noexcept { return true; }
  /// Untimed. Solids and paths must stay until the next call.
  /// @throws InputError where the engine refuses a solid.
  virtual void set(const Hexahedron& a, const RigidPath& path_a, const Hexahedron& b,
                   const RigidPath& path_b) = 0;
  /// Timed: the share of the path at which the two meet, as the engine says it; none: they do not.
  /// @throws std::exception as the engine does.
  virtual std::optional<double> impact() = 0;
};

/// A sweep and how to make one.
struct SweepEntry {
  std::string name;
  std::string description;  ///< one line, with library and version
  std::string backend;      ///< the narrowphase of the same library
  std::function<std::unique_ptr<Sweep>()> make;
};

}  // namespace touchstone
