#pragma once

#include <bit>
#include <cstdint>
#include <span>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

namespace touchstone::proof {

/// Calls sink(std::uint64_t) with every bit of one pair's answer: status, separation, normal, witness points
/// and the manifold points in use with their feature ids.
template <typename Sink>
void for_each_word(PairStatus status, const PairGeometry& geometry, std::span<const ContactPoint> points,
                   const Sink& sink) {
  const auto put = [&](double value) { sink(std::bit_cast<std::uint64_t>(value)); };
  const auto put_vector = [&](const Vector3& v) { put(v.x()), put(v.y()), put(v.z()); };
  sink(static_cast<std::uint64_t>(status));
  put(geometry.separation);
  put_vector(geometry.n_AB_W);
  put_vector(geometry.p_A_W);
  put_vector(geometry.p_B_W);
  sink(static_cast<std::uint64_t>(geometry.point_count));
  for (const ContactPoint& point : points.first(static_cast<std::size_t>(geometry.point_count))) {
    put_vector(point.p_A_W);
    put_vector(point.p_B_W);
    put(point.separation);
    sink(point.feature_id);
  }
}

}  // namespace touchstone::proof
