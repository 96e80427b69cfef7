#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <span>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/pose.hpp"
#include "touchstone/tests/proof/hash/result_hash.hpp"

namespace touchstone::proof {

/// Takes numbers bit by bit into one hash. NaN counts as one number: its sign and payload are no result.
class BitSink {
 public:
  void put(std::uint64_t word) { hash_.put(word); }
  void put(double value) { hash_.put(std::bit_cast<std::uint64_t>(std::isnan(value) ? kNaN : value)); }
  void put(const Vector3& v) { put(v.x()), put(v.y()), put(v.z()); }
  void put(const Matrix3& A) {
    for (int j = 0; j < 3; ++j) put(Vector3(A.col(j)));
  }
  void put(const Pose& X) { put(X.R), put(X.p); }
  void put(std::span<const double> values) {
    for (const double value : values) put(value);
  }
  std::uint64_t value() const { return hash_.value(); }

 private:
  Fnv1a hash_;
};

}  // namespace touchstone::proof
