#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "touchstone/contact_core/narrowphase/pair_class.hpp"
#include "touchstone/examples/measures/pairs/pair_set.hpp"

namespace touchstone::measures {

/// The right answer for one case.
struct PairTruth {
  PairClass pair_class = PairClass::separated;
  double separation = 0;  ///< signed [m]
  Vector3 n_AB_W = Vector3::Zero();
  bool normal_unique = false;

  bool contact() const { return pair_class != PairClass::separated; }
};

/// The reference of errors. Safe to call from several threads.
class Oracle {
 public:
  virtual ~Oracle() = default;
  virtual PairTruth truth(const WorldVertices& a, const WorldVertices& b) const = 0;
  /// The distance of p to the solid's surface [m].
  virtual double surface_distance(const WorldVertices& solid, const Vector3& p) const = 0;
  /// The area of the patch (narrowphase.hpp), projected along n [m2]: the hull of those corners of the clip
  /// of the two faces most (anti)parallel to n that are no further apart along n than `limit` [m].
  virtual double patch_area(const WorldVertices& a, const WorldVertices& b, const Vector3& n,
                            double limit) const = 0;
};

/// Backed by the `exact` adapter; null in a build without it.
std::unique_ptr<Oracle> make_exact_oracle();

/// Called now and then with the share done, from one thread at a time.
using Progress = std::function<void(double share)>;

/// The truth of every case of the set, on `threads` threads.
std::vector<PairTruth> compute_truth(const PairSet& set, const Oracle& oracle, int threads,
                                     const Progress& progress = {});

}  // namespace touchstone::measures
