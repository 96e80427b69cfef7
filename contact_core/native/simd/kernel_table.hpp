#pragma once

#include "contact_core/native/simd/box_kernels.hpp"
#include "contact_core/native/simd/depth_kernels.hpp"
#include "contact_core/native/simd/hull_kernels.hpp"
#include "contact_core/native/simd/parallelepiped_kernels.hpp"

// The table of one instruction set: included by kernels_<isa>.cpp only.

namespace touchstone::native::TOUCHSTONE_ISA {

template <class Pack>
struct Table {
  static Certified certify_box_pair(const PoseRecord& X_WA, const BoxRecord& a, const PoseRecord& X_WB,
                                    const BoxRecord& b) {
    return certify_box_pair_inline(X_WA, a, X_WB, b);
  }

  static void certify_boxes(const PoseRecord* poses, const BoxRecord* shapes, const PairIndices* pairs,
                            std::size_t count, Certified* out) {
    certify_boxes_inline<Pack>(poses, shapes, pairs, count, out);
  }

  static void certify_parallelepipeds(const PoseRecord* poses, const ParallelepipedRecord* shapes,
                                      const PairIndices* pairs, std::size_t count, Certified* out) {
    certify_parallelepipeds_inline<Pack>(poses, shapes, pairs, count, out);
  }

  static void measure_box_depths(const PoseRecord* poses, const BoxRecord* shapes, const PairIndices* pairs,
                                 std::size_t count, DepthRecord* out) {
    if (count == 1)
      measure_depths_inline<Double2, BoxSolid>(poses, shapes, pairs, count, out);
    else
      measure_depths_inline<Pack, BoxSolid>(poses, shapes, pairs, count, out);
  }

  static void measure_form_depths(const PoseRecord* poses, const FormRecord* shapes, const PairIndices* pairs,
                                  std::size_t count, DepthRecord* out) {
    if (count == 1)
      measure_depths_inline<Double2, FormSolid>(poses, shapes, pairs, count, out);
    else
      measure_depths_inline<Pack, FormSolid>(poses, shapes, pairs, count, out);
  }

  static void measure_hull_depth(const HullView& a, const HullView& b, double extent, double position,
                                 DepthRecord* out) {
    measure_hull_depth_inline<Pack>(a, b, extent, position, *out);
  }

  static constexpr Kernels named(const char* isa) {
    return {isa,
            Traits<Pack>::lanes,
            certify_box_pair,
            certify_boxes,
            certify_parallelepipeds,
            measure_box_depths,
            measure_form_depths,
            measure_hull_depth};
  }
};

}  // namespace touchstone::native::TOUCHSTONE_ISA
