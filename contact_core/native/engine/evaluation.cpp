#include "touchstone/contact_core/native/engine/evaluation.hpp"

#include "touchstone/contact_core/native/engine/pair_geometry.hpp"
#include "touchstone/contact_core/native/overlap/overlap.hpp"

namespace touchstone::native {
namespace {

/// Only pairs that are apart are withheld: a limit below 0, or none at all, is one of 0. The input is copied
/// there alone: a copy waits for the caller's stores, as long as a pair takes to be certified.
void compute_within_sound_limit(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input,
                                const NarrowphaseOutput& output, std::span<ContactPoint> points) {
  if (input.query.max_separation >= 0.0)
    return compute_geometry(set, kernels, input, output.status, output.geometry, points);
  NarrowphaseInput sound = input;
  sound.query.max_separation = 0.0;
  compute_geometry(set, kernels, sound, output.status, output.geometry, points);
}

}  // namespace

void evaluate(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input,
              const NarrowphaseOutput& output) {
  if (input.query.kind == QueryKind::overlap)
    overlap(set, kernels, input.pairs, input.poses, output.status, input.cache);
  else if (input.query.kind == QueryKind::distance)
    compute_within_sound_limit(set, kernels, input, output, {});
  else
    compute_within_sound_limit(set, kernels, input, output, output.points);
}

}  // namespace touchstone::native
