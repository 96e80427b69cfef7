#pragma once

#include "touchstone/contact_core/native/simd/kernels.hpp"
#include "touchstone/contact_core/native/simd/pack.hpp"

// Pairs in lanes: the loop over a batch.

namespace touchstone::native::TOUCHSTONE_ISA {

/// Separated goes first. Looked up: no branch.
TOUCHSTONE_INLINE Certified verdict(bool separated, bool overlapping) {
  static constexpr Certified kVerdicts[] = {Certified::unknown, Certified::separated, Certified::overlapping,
                                            Certified::separated};
  return kVerdicts[static_cast<unsigned>(separated) | static_cast<unsigned>(overlapping) << 1];
}

template <class Pack>
struct LaneVerdicts {
  MaskOf<Pack> separated;
  MaskOf<Pack> overlapping;
};

template <class Shape>
TOUCHSTONE_INLINE void prefetch(const PoseRecord* poses, const Shape* shapes, std::uint32_t i) {
  __builtin_prefetch(&poses[i].R[0]);
  __builtin_prefetch(&poses[i].p[2]);
  __builtin_prefetch(&shapes[i]);
  for (std::size_t line = 64; line < sizeof(Shape); line += 64)
    __builtin_prefetch((const char*)&shapes[i] + line);
}

/// Runs `body` on blocks of as many pairs as there are lanes; the last block is filled with its last pair.
template <class Pack, class Shape, class Body>
TOUCHSTONE_INLINE void for_each_lanes(const PoseRecord* poses, const Shape* shapes, const PairIndices* pairs,
                                      std::size_t count, const Body& body) {
  constexpr int kLanes = Traits<Pack>::lanes;
  constexpr std::size_t kAhead = 2 * kLanes;
  for (std::size_t first = 0; first < count; first += kLanes) {
    const std::size_t here = count - first < kLanes ? count - first : kLanes;
    const double *poses_a[kLanes], *poses_b[kLanes], *shapes_a[kLanes], *shapes_b[kLanes];
    for (std::size_t l = 0; l < kLanes; ++l) {
      const PairIndices pair = pairs[first + (l < here ? l : here - 1)];
      poses_a[l] = poses[pair.a].R, poses_b[l] = poses[pair.b].R;
      shapes_a[l] = (const double*)&shapes[pair.a], shapes_b[l] = (const double*)&shapes[pair.b];
    }
    for (std::size_t l = 0; l < kLanes && first + kAhead + l < count; ++l) {
      prefetch(poses, shapes, pairs[first + kAhead + l].a);
      prefetch(poses, shapes, pairs[first + kAhead + l].b);
    }
    body(first, here, poses_a, shapes_a, poses_b, shapes_b);
  }
}

template <class Pack, class Shape, class Check>
TOUCHSTONE_INLINE void for_each_block(const PoseRecord* poses, const Shape* shapes, const PairIndices* pairs,
                                      std::size_t count, Certified* out, const Check& check) {
  for_each_lanes<Pack>(poses, shapes, pairs, count,
                       [&](std::size_t first, std::size_t here, const auto& poses_a, const auto& shapes_a,
                           const auto& poses_b, const auto& shapes_b) {
                         const LaneVerdicts<Pack> verdicts = check(poses_a, shapes_a, poses_b, shapes_b);
                         const unsigned separated = bits(verdicts.separated);
                         const unsigned overlapping = bits(verdicts.overlapping);
                         for (std::size_t l = 0; l < here; ++l)
                           out[first + l] = verdict(separated >> l & 1u, overlapping >> l & 1u);
                       });
}

/// As for_each_block, on the lanes of both solids, which gather_solid() of their type fills.
template <class Pack, template <class> class Lanes, class Shape, class Check>
TOUCHSTONE_INLINE void for_each_two_solids(const PoseRecord* poses, const Shape* shapes,
                                           const PairIndices* pairs, std::size_t count, Certified* out,
                                           const Check& check) {
  for_each_block<Pack>(
      poses, shapes, pairs, count, out,
      [&](const auto& poses_a, const auto& shapes_a, const auto& poses_b, const auto& shapes_b) {
        Lanes<Pack> A, B;
        gather_solid(poses_a, shapes_a, A);
        gather_solid(poses_b, shapes_b, B);
        return check(A, B);
      });
}

}  // namespace touchstone::native::TOUCHSTONE_ISA
