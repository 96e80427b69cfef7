#pragma once

#include "contact_core/native/simd/box_kernels.hpp"
#include "contact_core/native/simd/parallelepiped_kernels.hpp"
#include "contact_core/native/simd/portal_kernels.hpp"

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

  static void certify_by_portal(const PoseRecord* poses, const VertexRecord* shapes, const PairIndices* pairs,
                                std::size_t count, int max_steps, Certified* out, PairAxis* axes) {
    if (axes)
      certify_by_portal_inline<Pack, true>(poses, shapes, pairs, count, max_steps, out, axes);
    else
      certify_by_portal_inline<Pack, false>(poses, shapes, pairs, count, max_steps, out, axes);
  }

  static void certify_by_axis(const PoseRecord* poses, const VertexRecord* shapes, const PairIndices* pairs,
                              std::size_t count, const PairAxis* axes, Certified* out) {
    certify_by_axis_inline<Pack>(poses, shapes, pairs, count, axes, out);
  }

  static constexpr Kernels named(const char* isa) {
    return {isa,
            Traits<Pack>::lanes,
            certify_box_pair,
            certify_boxes,
            certify_parallelepipeds,
            certify_by_portal,
            certify_by_axis};
  }
};

}  // namespace touchstone::native::TOUCHSTONE_ISA
