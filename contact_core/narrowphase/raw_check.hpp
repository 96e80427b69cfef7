#pragma once

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

namespace touchstone {

/// An engine's own call on objects already posed, without our interface around it: for benchmarks only.
class RawCheck {
 public:
  virtual ~RawCheck() = default;
  virtual void build(std::span<const Hexahedron> solids) = 0;
  virtual bool supports(QueryKind kind) const noexcept = 0;
  /// Untimed.
  virtual void set_poses(std::span<const Pose> poses) = 0;
  /// Timed: the engine's call for each pair. Returns how many pairs it reports in contact, so that no call is
  /// optimised away.
  virtual std::size_t run(std::span<const SolidPair> pairs, QueryKind kind) noexcept = 0;
};

}  // namespace touchstone
