#pragma once

#include <cstddef>
#include <cstdint>

#include "contact_core/native/certified.hpp"

// The checks that run on many pairs, or on one pair's axes, in the lanes of a vector register. Each is
// compiled once per instruction set (kernels_<isa>.cpp) and chosen when the program starts. Everything here
// is plain data, so that no inline function of a shared header is ever compiled for one instruction set and
// linked into another. Lanes never mix and nothing is contracted: the bits are the same on every instruction
// set.

namespace touchstone::native {

/// The pairs of a block, as indices into the arrays of poses and shapes.
struct PairIndices {
  std::uint32_t a;
  std::uint32_t b;
};

/// X_WS as twelve doubles: R by columns, then p. What Pose is in memory.
struct PoseRecord {
  double R[9];
  double p[3];
};

struct alignas(32) BoxRecord {
  double half_extents[3];
  double reach;  ///< their sum
};

/// See Parallelepiped.
struct alignas(64) ParallelepipedRecord {
  double half_edges[3][3];
  double centre[3];
  double deviation;
  double padding[3];
};

/// The vertices in the solid's frame. Not a number where the solid's magnitudes are not ordinary: nothing
/// then is certified.
struct alignas(64) VertexRecord {
  double x[8], y[8], z[8];
};

/// From A to B, any length.
struct PairAxis {
  double x, y, z, padding;
};

struct Kernels {
  const char* isa;
  int lanes;  ///< pairs at a time

  /// Boxes by their half-extents: the coarse pass of certify_boxes (box_box_overlap.hpp).
  Certified (*certify_box_pair)(const PoseRecord& X_WA, const BoxRecord& a, const PoseRecord& X_WB,
                                const BoxRecord& b);
  void (*certify_boxes)(const PoseRecord* poses, const BoxRecord* shapes, const PairIndices* pairs,
                        std::size_t count, Certified* out);
  /// As certify_parallelepipeds (parallelepiped_overlap.hpp).
  void (*certify_parallelepipeds)(const PoseRecord* poses, const ParallelepipedRecord* shapes,
                                  const PairIndices* pairs, std::size_t count, Certified* out);
  /// As certify_by_portal (portal.hpp), of any two solids; gives up after `max_steps`.
  /// @param axes null, or one a pair: set where the pair is found separated.
  void (*certify_by_portal)(const PoseRecord* poses, const VertexRecord* shapes, const PairIndices* pairs,
                            std::size_t count, int max_steps, Certified* out, PairAxis* axes);
  /// Separated where B certainly lies beyond A along its axis, else unknown. Any axes, numbers or not.
  void (*certify_by_axis)(const PoseRecord* poses, const VertexRecord* shapes, const PairIndices* pairs,
                          std::size_t count, const PairAxis* axes, Certified* out);
};

/// Those this machine can run, the plainest first.
struct KernelList {
  const Kernels* of[3];
  int count;
};
const KernelList& available_kernels();

/// The widest that this machine runs, or the one that the environment variable TOUCHSTONE_ISA names (generic,
/// avx2, avx512; ignored when the machine lacks it). Chosen once.
const Kernels& kernels();

}  // namespace touchstone::native
