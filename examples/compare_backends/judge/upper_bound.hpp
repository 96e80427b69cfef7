#pragma once

#include <cstddef>

namespace touchstone::comparison {

/// One-sided 95 % upper confidence bound of a share after `found` of `cases` independent draws (Clopper and
/// Pearson): the share at which `found` or fewer turn up in 5 % of such samples. None of n: 1 - 0.05^(1/n),
/// near 3 / n. 1 when all were found or there are no cases. It speaks of pairs drawn as these were.
double upper_bound_95(std::size_t found, std::size_t cases);

}  // namespace touchstone::comparison
