#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

// Private to contact_core/fit.

namespace touchstone::fit {

/// Some of `sets` that together hold every one of `elements`, as few as a local search finds: it takes a set
/// out, puts one in for an element that is then open, and lets elements that stay open count more and more.
/// The same on every machine, for integers alone decide.
/// @param sets each the elements, from 0, that it holds, every one once
/// @param start a cover: indices of sets
/// @param work how many scores of sets it may change, about: each costs some nanoseconds
/// @return a cover of no more sets than `start`; at once where least_sets() says that none has fewer
std::vector<std::size_t> fewer_sets(std::span<const std::vector<std::uint32_t>> sets, std::size_t elements,
                                    const std::vector<std::size_t>& start, std::uint64_t work);

/// No cover has fewer sets: elements, of which no two are in one set, found greedily from those that fewest
/// sets hold.
std::size_t least_sets(std::span<const std::vector<std::uint32_t>> sets, std::size_t elements);

}  // namespace touchstone::fit
