#pragma once

#include <array>

#include "touchstone/contact_core/native/distance/distance.hpp"
#include "touchstone/contact_core/native/simd/kernels.hpp"
#include "touchstone/contact_core/native/solids/placed_pair.hpp"
#include "touchstone/contact_core/native/solids/solid_set.hpp"

namespace touchstone::native {

/// A pair in the order of its content, so that (a, b) and (b, a) take the same code path.
struct OrderedPair {
  SolidPair pair;
  bool swapped;

  /// Of the caller's normal against this order's.
  double sign() const { return 1.0 - 2.0 * static_cast<double>(swapped); }
};

/// Writes the manifold of a placed pair for the caller. @param geometry the pair's, its point_count is set.
void write_manifold(const Kernels& kernels, const PlacedPair& placed, const SignedDistance& distance,
                    bool swapped, const Query& query, PairGeometry& geometry, ContactPoint* points);

/// The manifold of one pair of boxes or parallelepipeds whose geometry is written and within the query's
/// reach. @param kind of both, not general
void clip_pair(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input,
               const OrderedPair& pair, SolidKind kind, PairGeometry& geometry, ContactPoint* points);

/// Gathers boxes and parallelepipeds whose geometry is known for the clipping kernel, a few at a time. The
/// destructor writes the rest.
class ClipBatch {
 public:
  ClipBatch(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input);
  ~ClipBatch() { run(); }
  ClipBatch(const ClipBatch&) = delete;
  ClipBatch& operator=(const ClipBatch&) = delete;

  /// @param kind of both, not general. @param geometry of the caller's pair, within the query's reach; kept
  /// until written, as is `points`.
  void add(const OrderedPair& pair, SolidKind kind, PairGeometry& geometry, ContactPoint* points);

 private:
  void run();

  static constexpr std::size_t kMost = 32;

  const SolidSet& set_;
  const Kernels& kernels_;
  const NarrowphaseInput& input_;
  const int max_points_;
  SolidKind kind_ = SolidKind::box;
  std::size_t count_ = 0;
  std::array<ClipTask, kMost> tasks_;
  std::array<PairGeometry*, kMost> geometry_;
  std::array<ContactPoint*, kMost> points_;
};

/// The same for general hexahedra of six plane faces each.
class HullClipBatch {
 public:
  HullClipBatch(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input);
  ~HullClipBatch() { run(); }
  HullClipBatch(const HullClipBatch&) = delete;
  HullClipBatch& operator=(const HullClipBatch&) = delete;

  /// Whether both solids are such ones.
  bool takes(const SolidPair& pair) const;
  /// @param distance in the order of `pair`. @param about_origin whether its p_A is about A's first vertex,
  /// not the world's origin. @param geometry of the caller's pair, written but for its points and within the
  /// query's reach; kept until these are written, as is `points`.
  void add(const OrderedPair& pair, const SignedDistance& distance, bool about_origin, PairGeometry& geometry,
           ContactPoint* points);

 private:
  void run();
  void write(std::size_t i, const HullClipRecord& clipped) const;

  static constexpr std::size_t kMost = 32;

  const SolidSet& set_;
  const Kernels& kernels_;
  const NarrowphaseInput& input_;
  std::size_t count_ = 0;
  struct Pair {
    Vector3 p_A;
    bool about_origin, swapped;
    PairGeometry* geometry;
    ContactPoint* points;
  };
  std::array<HullClipTask, kMost> tasks_;
  std::array<Pair, kMost> pairs_;
};

}  // namespace touchstone::native
