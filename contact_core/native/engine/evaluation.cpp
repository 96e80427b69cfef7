#include "touchstone/contact_core/native/engine/evaluation.hpp"

#include "touchstone/contact_core/native/engine/pair_geometry.hpp"
#include "touchstone/contact_core/native/overlap/overlap.hpp"

namespace touchstone::native {
namespace {

/// Only pairs that are apart are withheld: a limit below 0, or none at all, is one of 0.
NarrowphaseInput with_sound_limit(const NarrowphaseInput& input) {
  NarrowphaseInput out = input;
  if (!(out.query.max_separation >= 0.0)) out.query.max_separation = 0.0;
  return out;
}

}  // namespace

void evaluate(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input,
              const NarrowphaseOutput& output) {
  if (input.query.kind == QueryKind::overlap)
    overlap(set, kernels, input.pairs, input.poses, output.status, input.cache);
  else if (input.query.kind == QueryKind::distance)
    compute_geometry(set, kernels, with_sound_limit(input), output.status, output.geometry, {});
  else
    compute_geometry(set, kernels, with_sound_limit(input), output.status, output.geometry, output.points);
}

}  // namespace touchstone::native
