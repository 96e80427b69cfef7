#pragma once

#include <array>
#include <string>
#include <vector>

#include "touchstone/contact_core/narrowphase/pair_observer.hpp"

namespace touchstone {

/// Keeps what it observes.
struct KeptPairs final : PairObserver {
  struct Observation {
    std::array<Vector3, 2> half_extents;
    std::array<Pose, 2> X_WS;
    PairStatus status;
    PairGeometry geometry;
    std::vector<ContactPoint> points;
    std::string by;
  };
  std::vector<Observation> all;

  void observe(const ObservedPair& pair) noexcept override {
    all.push_back({{pair.solids[0]->half_extents(), pair.solids[1]->half_extents()},
                   pair.X_WS,
                   pair.status,
                   pair.geometry,
                   {pair.points.begin(), pair.points.end()},
                   std::string(pair.by)});
  }
};

}  // namespace touchstone
