#pragma once

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/contact_core/native/solids/posed_pair.hpp"
#include "touchstone/contact_core/native/solids/solid_set.hpp"

namespace touchstone::native {

/// Whether neither sizes nor positions need scaling.
bool is_ordinary(const SolidSet& set, SolidIndex a, const Pose& X_WA, SolidIndex b, const Pose& X_WB);

/// A total order of posed solids by content, so that (a, b) and (b, a) take the same code path.
bool comes_first(const SolidSet& set, const SolidPair& pair, const Pose& X_WA, const Pose& X_WB);

/// A pair in the world, and about a common origin for the checks: there scaled by 2^exponent when its
/// magnitudes are not ordinary.
struct PlacedPair {
  WorldVertices a_W, b_W;
  PosedPair pair;
  Vector3 origin_W;  ///< unscaled
  int exponent = 0;

  /// From the checks' frame to the world.
  Vector3 to_world(const Vector3& p) const {
    return exponent == 0 ? Vector3(origin_W + p) : scaled_to_world(p);
  }
  double to_world(double length) const;
  /// And back.
  Vector3 from_world(const Vector3& p_W) const;
  double from_world(double length) const;

 private:
  Vector3 scaled_to_world(const Vector3& p) const;
};

void place(const SolidSet& set, const SolidPair& solids, const Pose& X_WA, const Pose& X_WB, bool ordinary,
           PlacedPair& out);
/// The same bits of an ordinary pair, by a kernel.
void place_in_lanes(const SolidSet& set, const Kernels& kernels, const SolidPair& solids,
                    std::span<const Pose> poses, PlacedPair& out);

}  // namespace touchstone::native
