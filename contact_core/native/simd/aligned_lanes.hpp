#pragma once

#include "touchstone/contact_core/native/simd/mpr_kernels.hpp"

// certify_aligned() (aligned_hulls.hpp) of pairs in lanes: comparisons of the bits of world_vertices(), and
// no other rounding than that of the middle, which any value may stand for. Coordinates that are no numbers
// compare to nothing, so that they leave a pair unknown.

namespace touchstone::native::TOUCHSTONE_ISA {

template <class Pack>
struct IntervalLanes {
  Pack low, high;
};

/// Of hulls: the intervals that their coordinates fill, and those of boxes that they hold.
template <class Pack>
struct AlignedLanes {
  IntervalLanes<Pack> outer[3], inner[3];
  MaskOf<Pack> has_inner;

  TOUCHSTONE_INLINE explicit AlignedLanes(const VertexLanes<Pack>& v) {
    // The octants that each vertex may be in, as bits.
    MaskOf<Pack> octants[8];
    has_inner = ~MaskOf<Pack>{};
    for (int i = 0; i < 8; ++i) octants[i] = has_inner;
    add(v.x, 0x55, outer[0], inner[0], octants), add(v.y, 0x33, outer[1], inner[1], octants),
        add(v.z, 0x0f, outer[2], inner[2], octants);
    MaskOf<Pack> filled{};
    for (int i = 0; i < 8; ++i) filled |= octants[i];
    has_inner &= (filled & (MaskOf<Pack>{} + 0xff)) == MaskOf<Pack>{} + 0xff;
  }

 private:
  /// @param low_octants those below the middle
  TOUCHSTONE_INLINE void add(const Pack (&c)[8], long long low_octants, IntervalLanes<Pack>& fills,
                             IntervalLanes<Pack>& holds, MaskOf<Pack> (&octants)[8]) {
    fills = {c[0], c[0]};
    for (int i = 1; i < 8; ++i) fills = {least(c[i], fills.low), greatest(c[i], fills.high)};
    const Pack half = all<Pack>(0.5), middle = half * fills.low + half * fills.high;
    // From the highest of the low vertices to the lowest of the high ones.
    holds = fills;
    for (int i = 0; i < 8; ++i) {
      const MaskOf<Pack> is_high = c[i] > middle;
      holds.low = greatest(is_high ? holds.low : c[i], holds.low);
      holds.high = least(is_high ? c[i] : holds.high, holds.high);
      octants[i] &= (MaskOf<Pack>{} + low_octants) ^ (is_high & (MaskOf<Pack>{} + 0xff));
    }
    has_inner &= holds.low <= holds.high;
  }
};

/// As goes_through() in aligned_hulls.cpp.
template <class Pack>
TOUCHSTONE_INLINE MaskOf<Pack> goes_through(const AlignedLanes<Pack>& hull, const VertexLanes<Pack>& v) {
  MaskOf<Pack> before_end[3] = {}, past_start[3] = {};
  for (int i = 0; i < 8; ++i) {
    const Pack c[3] = {v.x[i], v.y[i], v.z[i]};
    MaskOf<Pack> below[3], above[3];
    for (int k = 0; k < 3; ++k) below[k] = c[k] <= hull.inner[k].high, above[k] = hull.inner[k].low <= c[k];
    for (int k = 0; k < 3; ++k) {
      const int k1 = (k + 1) % 3, k2 = (k + 2) % 3;
      const MaskOf<Pack> beside = (below[k1] & above[k1]) & (below[k2] & above[k2]);
      before_end[k] |= beside & below[k], past_start[k] |= beside & above[k];
    }
  }
  return hull.has_inner & ((before_end[0] & past_start[0]) | (before_end[1] & past_start[1]) |
                           (before_end[2] & past_start[2]));
}

template <class Pack>
TOUCHSTONE_INLINE LaneVerdicts<Pack> certify_aligned_lanes(const VertexLanes<Pack>& a_W,
                                                           const VertexLanes<Pack>& b_W) {
  const AlignedLanes<Pack> a(a_W), b(b_W);
  LaneVerdicts<Pack> out{{}, a.has_inner & b.has_inner};
  for (int k = 0; k < 3; ++k) {
    out.separated |= (a.outer[k].low > b.outer[k].high) | (b.outer[k].low > a.outer[k].high);
    out.overlapping &= (a.inner[k].low <= b.inner[k].high) & (b.inner[k].low <= a.inner[k].high);
  }
  out.overlapping |= goes_through(a, b_W) | goes_through(b, a_W);
  return out;
}

template <class Pack>
TOUCHSTONE_INLINE void certify_aligned_inline(const PoseRecord* poses, const VertexRecord* shapes,
                                              const PairIndices* pairs, std::size_t count, Certified* out) {
  for_each_block<Pack>(
      poses, shapes, pairs, count, out,
      [&](const auto& poses_a, const auto& shapes_a, const auto& poses_b, const auto& shapes_b) {
        const PoseLanes<Pack> X_WA = gather_poses<Pack>(poses_a), X_WB = gather_poses<Pack>(poses_b);
        VertexLanes<Pack> a_W, b_W;
        Pack extent{};
        place_vertices<Pack>(shapes_a, X_WA, &X_WA.p, extent, a_W);
        place_vertices<Pack>(shapes_b, X_WB, &X_WB.p, extent, b_W);
        return certify_aligned_lanes(a_W, b_W);
      });
}

}  // namespace touchstone::native::TOUCHSTONE_ISA
