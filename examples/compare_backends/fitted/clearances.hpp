#pragma once

#include <memory>
#include <vector>

#include "touchstone/contact_core/broadphase/broadphase.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/examples/compare_backends/fitted/fitted_covers.hpp"

namespace touchstone::comparison {

/// The distance of a probe from a cover, by a backend's answer.
struct Clearance {
  double value = 0.0;      ///< [m]; 0 in contact, +inf beyond the range
  bool is_known = true;    ///< false: a pair that counts was unsupported or failed
  bool is_decided = true;  ///< false: a pair was undecided; its figure counts
  std::size_t pairs = 0;   ///< that were asked
};

/// A frame: one probe moves, the cover stands. The broadphase is `native`'s for every backend.
class ClearanceQuery {
 public:
  /// @throws InputError: the backend refuses a solid.
  ClearanceQuery(const FittedCover& cover, const ClearancePoses& poses,
                 std::unique_ptr<Narrowphase> narrowphase);

  /// @param X_MP of the probe. Allocates nothing after warm-up.
  Clearance operator()(const Pose& X_MP);
  /// Nanoseconds of this thread's processor that the narrowphase alone took so far. A call reads that clock
  /// twice; one reading a call is in these.
  double narrowphase_ns() const { return narrowphase_ns_; }

 private:
  HexahedronTree probe_;
  const HexahedronTree& cover_;
  double range_;
  std::unique_ptr<Broadphase> broadphase_;
  std::unique_ptr<Narrowphase> narrowphase_;
  std::unique_ptr<Narrowphase::Workspace> workspace_;
  std::vector<Pose> poses_;  ///< of the probe, then of the cover's hexahedra
  std::vector<SolidPair> pairs_;
  std::vector<PairStatus> status_;
  std::vector<PairGeometry> geometry_;
  double narrowphase_ns_ = 0.0;
};

}  // namespace touchstone::comparison
