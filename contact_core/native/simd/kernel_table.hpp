#pragma once

#include "touchstone/contact_core/native/simd/aligned_lanes.hpp"
#include "touchstone/contact_core/native/simd/box_kernels.hpp"
#include "touchstone/contact_core/native/simd/box_pair_clip.hpp"
#include "touchstone/contact_core/native/simd/box_pair_depth.hpp"
#include "touchstone/contact_core/native/simd/depth_kernels.hpp"
#include "touchstone/contact_core/native/simd/distance_kernels.hpp"
#include "touchstone/contact_core/native/simd/flush_frame.hpp"
#include "touchstone/contact_core/native/simd/hull_clip_lanes.hpp"
#include "touchstone/contact_core/native/simd/hull_depth_batch.hpp"
#include "touchstone/contact_core/native/simd/hull_distance_kernels.hpp"
#include "touchstone/contact_core/native/simd/hull_kernels.hpp"
#include "touchstone/contact_core/native/simd/hull_pair_clip.hpp"
#include "touchstone/contact_core/native/simd/manifold_kernels.hpp"
#include "touchstone/contact_core/native/simd/mpr_kernels.hpp"
#include "touchstone/contact_core/native/simd/pair_facets.hpp"
#include "touchstone/contact_core/native/simd/parallelepiped_kernels.hpp"
#include "touchstone/contact_core/native/simd/touching_boxes.hpp"

// The table of one instruction set: included by kernels_<isa>.cpp only.

namespace touchstone::native::TOUCHSTONE_ISA {

Double2 four_or(Double2);
Double4 four_or(Double4);
Double4 four_or(Double8);

template <class Pack>
struct Table {
  /// Verdicts, depths and distances of one pair take four of its axes or facets at a time. In two lanes the
  /// kernels of many pairs are faster, for one pair, too.
  static constexpr bool kHasFour = Traits<Pack>::lanes >= 4;
  /// The search of one pair of hulls, twice four vertices each, has no use for wider packs.
  using OnePair = decltype(four_or(Pack{}));

  static Certified certify_box_pair(const PoseRecord& X_WA, const BoxRecord& a, const PoseRecord& X_WB,
                                    const BoxRecord& b) {
    if constexpr (kHasFour)
      return certify_box_pair_inline(X_WA, a, X_WB, b);
    else
      return certify_one_of_many<Pack>(X_WA, a, X_WB, b);
  }

  static void certify_boxes(const PoseRecord* poses, const BoxRecord* shapes, const PairIndices* pairs,
                            std::size_t count, Certified* out) {
    certify_boxes_inline<Pack>(poses, shapes, pairs, count, out);
  }

  static void find_boxes_beyond(const PoseRecord* poses, const BoxRecord* shapes, const PairIndices* pairs,
                                std::size_t count, double reach, Certified* out) {
    find_boxes_beyond_inline<Pack>(poses, shapes, pairs, count, reach, out);
  }

  static void certify_touching_boxes(const PoseRecord* poses, const BoxRecord* shapes,
                                     const PairIndices* pairs, std::size_t count, Certified* out) {
    if (count == 1)
      certify_touching_boxes_inline<Double2>(poses, shapes, pairs, count, out);
    else
      certify_touching_boxes_inline<Pack>(poses, shapes, pairs, count, out);
  }

  static double put_into_frame(const VertexRecord& a_W, const VertexRecord& b_W, const PlaneFrame& plane,
                               VertexRecord& a, VertexRecord& b) {
    return put_into_frame_inline<Pack>(a_W, b_W, plane, a, b);
  }

  static void certify_parallelepipeds(const PoseRecord* poses, const Parallelepiped* shapes,
                                      const PairIndices* pairs, std::size_t count, Certified* out) {
    certify_parallelepipeds_inline<Pack>(poses, shapes, pairs, count, out);
  }

  static void certify_aligned(const PoseRecord* poses, const VertexRecord* shapes, const PairIndices* pairs,
                              std::size_t count, Certified* out) {
    certify_aligned_inline<Pack>(poses, shapes, pairs, count, out);
  }

  static void certify_by_mpr(const PoseRecord* poses, const VertexRecord* shapes, const PairIndices* pairs,
                             std::size_t count, int max_steps, Certified* out, PairAxis* axes) {
    if (axes)
      certify_by_mpr_inline<Pack, true>(poses, shapes, pairs, count, max_steps, out, axes);
    else
      certify_by_mpr_inline<Pack, false>(poses, shapes, pairs, count, max_steps, out, axes);
  }

  static void certify_by_axis(const PoseRecord* poses, const VertexRecord* shapes, const PairIndices* pairs,
                              std::size_t count, const PairAxis* axes, Certified* out) {
    certify_by_axis_inline<Pack>(poses, shapes, pairs, count, axes, out);
  }

  static void compute_box_depths(const PoseRecord* poses, const BoxRecord* shapes, const PairIndices* pairs,
                                 std::size_t count, DepthRecord* out) {
    if (count == 1)
      compute_box_pair_depth(poses, shapes, *pairs, PairNeed::distance, out);
    else
      compute_depths_inline<Pack, BoxSolid>(poses, shapes, pairs, count, out);
  }

  static void compute_box_pair_depth(const PoseRecord* poses, const BoxRecord* shapes, PairIndices pair,
                                     PairNeed need, DepthRecord* out) {
    if constexpr (kHasFour)
      compute_box_pair_depth_inline(poses[pair.a], shapes[pair.a], poses[pair.b], shapes[pair.b], need, out);
    else
      compute_depths_inline<Pack, BoxSolid>(poses, shapes, &pair, 1, out, need == PairNeed::contacts);
  }

  static void compute_parallelepiped_depths(const PoseRecord* poses, const ParallelepipedEdges* shapes,
                                            const PairIndices* pairs, std::size_t count, DepthRecord* out) {
    if (count == 1)
      compute_depths_inline<Double2, ParallelepipedSolid>(poses, shapes, pairs, count, out);
    else
      compute_depths_inline<Pack, ParallelepipedSolid>(poses, shapes, pairs, count, out);
  }

  static double place_hulls(const PoseRecord& X_WA, const VertexRecord& a_S, const PoseRecord& X_WB,
                            const VertexRecord& b_S, VertexRecord& a_W, VertexRecord& b_W, VertexRecord& a,
                            VertexRecord& b) {
    return place_hulls_inline<Pack>(X_WA, a_S, X_WB, b_S, a_W, b_W, a, b);
  }

  static void compute_hull_depth(const HullView& a, const HullView& b, double extent, double position,
                                 DepthRecord* out) {
    compute_hull_depth_inline<Pack>(a, b, extent, position, *out);
  }

  static void compute_hull_depths(const PoseRecord* poses, const VertexRecord* shapes, const HullTask* tasks,
                                  std::size_t count, std::size_t fetched) {
    compute_hull_depths_inline<Pack>(poses, shapes, tasks, count, fetched);
  }

  template <class Lanes, template <class> class Kind, class Shape>
  static void compute_distances_in(const PoseRecord* poses, const Shape* shapes, const PairIndices* pairs,
                                   const std::uint8_t* axes, std::size_t count, DistanceRecord* out) {
    compute_distances_inline<false, Lanes, Kind>(
        poses, shapes, pairs, count, out,
        [axes](const Zonotope<Lanes>& W, std::size_t first, std::size_t here) __attribute__((always_inline)) {
          return axes != nullptr ? facets_of<Lanes>(axes + first, here) : choose_facet<false>(W);
        });
  }

  template <template <class> class Kind, class Shape>
  static void compute_distances(const PoseRecord* poses, const Shape* shapes, const PairIndices* pairs,
                                const std::uint8_t* axes, std::size_t count, DistanceRecord* out) {
    if (count == 1)
      compute_distances_in<Double2, Kind>(poses, shapes, pairs, axes, count, out);
    else
      compute_distances_in<Pack, Kind>(poses, shapes, pairs, axes, count, out);
  }

  template <template <class> class Kind, class Shape>
  static void compute_distances_accurately(const PoseRecord* poses, const Shape* shapes,
                                           const PairIndices* pairs, std::size_t count, DistanceRecord* out) {
    const auto choose_one = [](const Zonotope<Double2>& W, std::size_t, std::size_t) {
      if constexpr (kHasFour)
        return choose_pair_facet(W);
      else
        return choose_facet<true>(W);
    };
    const auto choose = [](const Zonotope<Pack>& W, std::size_t, std::size_t) {
      return choose_facet<true>(W);
    };
    if (count == 1)
      compute_distances_inline<true, Double2, Kind>(poses, shapes, pairs, count, out, choose_one);
    else
      compute_distances_inline<true, Pack, Kind>(poses, shapes, pairs, count, out, choose);
  }

  static void compute_hull_distances(const PoseRecord* poses, const VertexRecord* shapes,
                                     const PairIndices* pairs, std::size_t count, DistanceRecord* out) {
    if (count == 1)
      compute_hull_distance_inline<OnePair>(poses, shapes, *pairs, out);
    else
      compute_hull_distances_inline<Pack>(poses, shapes, pairs, count, out);
  }

  static void clip_boxes(const PoseRecord* poses, const BoxRecord* shapes, const ClipTask* tasks,
                         std::size_t count, double max_point_separation, ClipRecord* out) {
    if (!kHasFour || count != 1)
      return clip_inline<Pack, BoxSolid>(poses, shapes, tasks, count, max_point_separation, out);
    const PairIndices pair = tasks->pair;
    *out = clip_box_pair(poses[pair.a], shapes[pair.a], poses[pair.b], shapes[pair.b], *tasks,
                         max_point_separation);
  }

  template <template <class> class Solid, class Record>
  static void clip(const PoseRecord* poses, const Record* shapes, const ClipTask* tasks, std::size_t count,
                   double max_point_separation, ClipRecord* out) {
    if (count == 1)
      clip_inline<Double2, Solid>(poses, shapes, tasks, count, max_point_separation, out);
    else
      clip_inline<Pack, Solid>(poses, shapes, tasks, count, max_point_separation, out);
  }

  static void clip_hulls(const PoseRecord* poses, const VertexRecord* shapes, const HullClipTask* tasks,
                         std::size_t count, double max_point_separation, HullClipRecord* out) {
    clip_hulls_inline<Pack>(poses, shapes, tasks, count, max_point_separation, out);
  }

  static void clip_hull_pair(const QuadView& a, const QuadView& b, const double (&n_separation)[4],
                             double extent, double max_point_separation, HullClipRecord* out) {
    clip_hull_pair_inline<Pack>(a, b, n_separation, extent, max_point_separation, *out);
  }

  static constexpr Kernels named(const char* isa) {
    return {
        .isa = isa,
        .lanes = Traits<Pack>::lanes,
        .certify_box_pair = certify_box_pair,
        .certify_boxes = certify_boxes,
        .certify_touching_boxes = certify_touching_boxes,
        .find_boxes_beyond = find_boxes_beyond,
        .put_into_frame = put_into_frame,
        .certify_parallelepipeds = certify_parallelepipeds,
        .certify_aligned = certify_aligned,
        .certify_by_mpr = certify_by_mpr,
        .certify_by_axis = certify_by_axis,
        .compute_box_depths = compute_box_depths,
        .compute_parallelepiped_depths = compute_parallelepiped_depths,
        .place_hulls = place_hulls,
        .compute_box_pair_depth = compute_box_pair_depth,
        .compute_hull_depth = compute_hull_depth,
        .compute_hull_depths = compute_hull_depths,
        .compute_box_distances = compute_distances<BoxZonotope>,
        .compute_parallelepiped_distances = compute_distances<ParallelepipedZonotope>,
        .compute_box_distances_accurately = compute_distances_accurately<BoxZonotope>,
        .compute_parallelepiped_distances_accurately = compute_distances_accurately<ParallelepipedZonotope>,
        .compute_hull_distances = compute_hull_distances,
        .clip_boxes = clip_boxes,
        .clip_parallelepipeds = clip<ParallelepipedSolid>,
        .clip_hulls = clip_hulls,
        .clip_hull_pair = clip_hull_pair};
  }
};

}  // namespace touchstone::native::TOUCHSTONE_ISA
