#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

namespace touchstone {

/// An engine's question and the answer to it, in this project's terms (narrowphase.hpp). Borrowed
/// for the time of the call.
struct ObservedPair {
  std::array<const Hexahedron*, 2> solids;
  std::array<Pose, 2> X_WS;
  PairStatus status;
  /// The geometry at the deepest point; NaN where the engine gave none, as for pairs that are apart.
  PairGeometry geometry;
  std::span<const ContactPoint> points;
  std::string_view by;  ///< engine and check, such as "Bullet, its own check"
};

/// Sees the pairs that pass through an engine with one of our plugins. Called from the engine's threads.
class PairObserver {
 public:
  virtual ~PairObserver() = default;
  virtual void observe(const ObservedPair& pair) noexcept = 0;
};

/// The check whose answer an engine's plug-in returns to the engine.
enum class EngineCheck : std::uint8_t {
  native,  ///< ours
  own,     ///< the engine's, for observing it
};

}  // namespace touchstone
