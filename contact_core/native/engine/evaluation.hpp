#pragma once

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/contact_core/native/solids/solid_set.hpp"

namespace touchstone::native {

/// Narrowphase::evaluate() of the solids' cores: of the solids themselves where none is rounded.
void evaluate(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input,
              const NarrowphaseOutput& output);

/// The same of sets with rounded solids. Runs of pairs without a radius take the way above. A pair with one
/// is asked for its cores' signed distance, which is the solids' by the radii; where that is nearer to the
/// sum of the radii than kSurely times the pair's scale, integers decide the class (rounded_predicate.hpp).
void evaluate_rounded(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input,
                      const NarrowphaseOutput& output);

}  // namespace touchstone::native
