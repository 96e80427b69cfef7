#pragma once

#include <cstddef>

#include "touchstone/adapters/c_interface/touchstone.h"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

// The C structs lie in memory as ours do: batches go through without a copy. What no longer did would not
// compile.

namespace touchstone::c_interface {

static_assert(sizeof(touchstone_pair) == sizeof(SolidPair) && offsetof(SolidPair, b) == 4);
static_assert(sizeof(touchstone_pose) == sizeof(Pose) && offsetof(Pose, p) == 72);
static_assert(sizeof(touchstone_status) == sizeof(PairStatus));
static_assert(sizeof(touchstone_geometry) == sizeof(PairGeometry));
static_assert(offsetof(PairGeometry, n_AB_W) == offsetof(touchstone_geometry, n_AB_W) &&
              offsetof(PairGeometry, p_A_W) == offsetof(touchstone_geometry, p_A_W) &&
              offsetof(PairGeometry, p_B_W) == offsetof(touchstone_geometry, p_B_W) &&
              offsetof(PairGeometry, point_count) == offsetof(touchstone_geometry, point_count));
static_assert(sizeof(touchstone_point) == sizeof(ContactPoint));
static_assert(offsetof(ContactPoint, p_B_W) == offsetof(touchstone_point, p_B_W) &&
              offsetof(ContactPoint, separation) == offsetof(touchstone_point, separation) &&
              offsetof(ContactPoint, feature_id) == offsetof(touchstone_point, feature_id));
static_assert(TOUCHSTONE_SEPARATED == static_cast<int>(PairStatus::separated) &&
              TOUCHSTONE_OVERLAPPING == static_cast<int>(PairStatus::overlapping) &&
              TOUCHSTONE_UNDECIDED == static_cast<int>(PairStatus::undecided) &&
              TOUCHSTONE_FAILED == static_cast<int>(PairStatus::failed) &&
              TOUCHSTONE_UNSUPPORTED == static_cast<int>(PairStatus::unsupported));
static_assert(TOUCHSTONE_OVERLAP == static_cast<int>(QueryKind::overlap) &&
              TOUCHSTONE_DISTANCE == static_cast<int>(QueryKind::distance) &&
              TOUCHSTONE_MANIFOLD == static_cast<int>(QueryKind::manifold));
static_assert(TOUCHSTONE_MAX_POINTS == kMaxManifoldPoints);

inline touchstone_query c_query(const Query& query) {
  return {static_cast<int32_t>(query.kind), query.max_points, query.max_separation,
          query.max_point_separation};
}

/// The arrays as the C side sees them; borrowed.
inline touchstone_input c_input(const NarrowphaseInput& input) {
  return {reinterpret_cast<const touchstone_pair*>(input.pairs.data()), input.pairs.size(),
          reinterpret_cast<const touchstone_pose*>(input.poses.data()), input.poses.size(),
          c_query(input.query)};
}
inline touchstone_output c_output(const NarrowphaseOutput& output) {
  return {reinterpret_cast<touchstone_status*>(output.status.data()),
          reinterpret_cast<touchstone_geometry*>(output.geometry.data()),
          reinterpret_cast<touchstone_point*>(output.points.data())};
}

inline touchstone_capabilities c_capabilities(const Capabilities& of) {
  const auto flag = [](bool value) { return static_cast<uint8_t>(value ? 1 : 0); };
  return {flag(of.distance),
          flag(of.penetration),
          flag(of.manifold),
          flag(of.overlap_complete),
          flag(of.deterministic),
          flag(of.thread_safe),
          {0, 0},
          of.scalar_bits,
          0,
          of.resolution.absolute,
          of.resolution.relative,
          of.resolution.of_depth};
}
inline Capabilities capabilities_of(const touchstone_capabilities& c) {
  return {c.distance != 0,
          c.penetration != 0,
          c.manifold != 0,
          false,  // rounded_solids: corners come without a radius
          c.overlap_complete != 0,
          c.scalar_bits,
          c.deterministic != 0,
          c.thread_safe != 0,
          {c.absolute_resolution, c.relative_resolution, c.depth_resolution}};
}

}  // namespace touchstone::c_interface
