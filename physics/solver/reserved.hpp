#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

// Memory for steps that are not to wait for it.

namespace touchstone::physics {

/// Rows of the largest dense problem in steps whose work is bounded, or few more: their matrices are written.
inline constexpr std::size_t kDenseRows = 64;

/// Of each list at most so much is written [bytes]: a thousand bodies with ten contacts each take less, and
/// steps of the default work get through no more. Lists that may grow with squares (joints of a mechanism,
/// for each of thousands of bodies: a GB) stay addresses beyond, which cost no memory until they are used.
inline constexpr std::size_t kMostWritten = std::size_t{8} << 20;

/// Reserves, and has the operating system give the memory now: a page that is first written to in a step
/// costs as much as some Newton steps. @param written of the count, where more is reserved than most problems
/// take; kMostWritten at most.
template <class T>
void reserve_written(std::vector<T>& vector, std::size_t count, std::size_t written) {
  if (count <= vector.capacity()) return;
  vector.reserve(count);
  const std::size_t size = vector.size();
  vector.resize(std::max(size, std::min({written, count, kMostWritten / sizeof(T)})));
  vector.resize(size);
}
template <class T>
void reserve_written(std::vector<T>& vector, std::size_t count) {
  reserve_written(vector, count, count);
}

}  // namespace touchstone::physics
