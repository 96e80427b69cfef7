#pragma once

#include <memory>
#include <vector>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

namespace touchstone::physics {

/// The pairs of solids that a GapNarrowphase sees: those of pairs of objects that are marked.
class SeenPairs {
 public:
  /// @param object_of by solid. All pairs are seen at first.
  SeenPairs(std::vector<std::uint32_t> object_of, std::size_t objects)
      : objects_(objects), object_of_(std::move(object_of)), is_seen_(objects * objects, 1) {}
  void set(std::size_t a, std::size_t b, bool is_seen) {
    is_seen_[a * objects_ + b] = is_seen_[b * objects_ + a] = is_seen ? 1 : 0;
  }
  bool sees(const SolidPair& pair) const {
    return is_seen_[object_of_[pair.a] * objects_ + object_of_[pair.b]] != 0;
  }

 private:
  std::size_t objects_;
  std::vector<std::uint32_t> object_of_;
  std::vector<std::uint8_t> is_seen_;
};

/// Wraps any narrowphase with manifolds so that solids meet a gap g before they touch: separations are less
/// by g, and B's points are g nearer to A. Hidden pairs are `separated` at +inf. Dynamics over it lets bodies
/// rest g apart, where a ContactWorld of gap g lets them stand.
///
/// Answers queries for distance and manifold; `overlap`, which has no separation, is `unsupported`.
/// evaluate() does not allocate.
class GapNarrowphase final : public Narrowphase {
 public:
  /// @param seen has room for the pairs of build()'s solids; it is shared. @param gap g [m], finite and >= 0.
  /// @throws InputError: no narrowphase, one without distances, depths or manifolds; another gap.
  GapNarrowphase(std::unique_ptr<Narrowphase> inner, double gap, std::shared_ptr<const SeenPairs> seen);

  std::string_view name() const noexcept override { return inner_->name(); }
  const Capabilities& capabilities() const noexcept override { return inner_->capabilities(); }
  void build(std::span<const Hexahedron> solids) override { inner_->build(solids); }
  std::unique_ptr<Workspace> make_workspace() const override { return inner_->make_workspace(); }
  void evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                Workspace& workspace) const noexcept override;

 private:
  void bring_nearer(PairStatus& status, PairGeometry& geometry, std::span<ContactPoint> points) const;

  std::unique_ptr<Narrowphase> inner_;
  double gap_;
  std::shared_ptr<const SeenPairs> seen_;
};

}  // namespace touchstone::physics
