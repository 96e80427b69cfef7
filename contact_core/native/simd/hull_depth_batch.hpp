#pragma once

#include "touchstone/contact_core/native/simd/hull_distance_kernels.hpp"
#include "touchstone/contact_core/native/simd/hull_kernels.hpp"

// hull_kernels.hpp for many pairs of regular hulls, as most solids have: one after another, their vertices
// and faces in lanes. Pairs in lanes took twice the instructions: to gather what pairs have, to keep it in
// memory, as no registers hold it, and to hand it to the code of one pair where few edges are left. Every
// number results from the same operations in the same order as there, so the bits are the same.

namespace touchstone::native::TOUCHSTONE_ISA {

/// A pair placed in the world, and its faces compared.
struct ComparedPair {
  PosedHull A, B;
  Magnitudes size;
  FaceStage faces;
};

/// As find_hull_depth() has it.
TOUCHSTONE_INLINE double position_of(const Point& origin, double extent, const double* p_A,
                                     const double* p_B) {
  const double near = largest_of(origin) + extent;
  const double beyond =
      greatest(largest_of(Point{p_A[0], p_A[1], p_A[2]}), largest_of(Point{p_B[0], p_B[1], p_B[2]})) - near;
  return near + kFarRoundoffs * greatest(beyond, 0.0);
}

template <class Pack>
TOUCHSTONE_INLINE void compare_pair(const PoseRecord* poses, const VertexRecord* shapes, const HullTask& task,
                                    ComparedPair& out) {
  const PoseRecord &X_WA = poses[task.pair.a], &X_WB = poses[task.pair.b];
  PlacedHulls& placed = *task.placed;
  Pack reach{}, extent{};
  place_vertices<Pack>(X_WA, shapes[task.pair.a], reach, placed.a);
  place_vertices<Pack>(X_WB, shapes[task.pair.b], reach, placed.b);
  const Point origin = {placed.a[0], placed.a[8], placed.a[16]};
  shift<Pack>(origin, placed.a, extent), shift<Pack>(origin, placed.b, extent);
  placed.origin[0] = origin.x, placed.origin[1] = origin.y, placed.origin[2] = origin.z;
  out.size.extent = greatest_lane(extent);
  out.size.position = position_of(origin, out.size.extent, X_WA.p, X_WB.p);
  // Faces.
  out.A.vertices = placed.a, out.B.vertices = placed.b;
  pose_faces<Pack>(*task.a, X_WA.R, out.A), pose_faces<Pack>(*task.b, X_WB.R, out.B);
  compare_faces<Pack>(out.A, kRegularFaces, out.B, kRegularFaces, out.size, out.faces);
}

TOUCHSTONE_INLINE void prefetch_hull(const PlainHull& hull) {
  for (std::size_t line = 0; line < sizeof hull; line += 64) __builtin_prefetch((const char*)&hull + line);
}

/// @param fetched tasks from the first on that are there, to fetch what later calls read
template <class Pack>
TOUCHSTONE_INLINE void compute_hull_depths_inline(const PoseRecord* poses, const VertexRecord* shapes,
                                                  const HullTask* tasks, std::size_t count,
                                                  std::size_t fetched) {
  // So many at a time have their faces compared, without a branch; then come edges. Meanwhile as many later
  // ones are fetched, little by little, as only so many lines can be on their way.
  constexpr std::size_t kTogether = 4;
  ComparedPair pairs[kTogether];
  for (std::size_t first = 0; first < count; first += kTogether) {
    const std::size_t here = count - first < kTogether ? count - first : kTogether;
    for (std::size_t i = 0; i < here; ++i) {
      if (const std::size_t later = first + kTogether + i; later < fetched)
        prefetch(poses, shapes, tasks[later].pair.a), prefetch(poses, shapes, tasks[later].pair.b);
      compare_pair<Pack>(poses, shapes, tasks[first + i], pairs[i]);
    }
    for (std::size_t i = 0; i < here; ++i) {
      if (const std::size_t later = first + kTogether + i; later < fetched)
        prefetch_hull(*tasks[later].a), prefetch_hull(*tasks[later].b);
      const HullTask& task = tasks[first + i];
      const ComparedPair& pair = pairs[i];
      if (__builtin_expect(task.a->is_regular & task.b->is_regular, 1))
        finish_depth<Pack>(pair.A, kRegularFaces, pair.B, kRegularFaces, pair.faces, pair.size, *task.depth);
    }
  }
}

}  // namespace touchstone::native::TOUCHSTONE_ISA
