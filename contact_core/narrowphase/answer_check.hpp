#pragma once

#include <cstddef>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

/// @file
/// Answers of code that is not ours (a plug-in, another process), held against the interface's contract
/// before anyone reads them. Their accuracy is not checked here: it is judged like any backend's.

namespace touchstone {

/// Returns how one pair's answer breaks the contract, as a string literal; nullptr where it does not. An
/// answer breaks it by an unknown status or, where it carries geometry, by a separation or witness point that
/// is not finite (+inf is allowed for `separated` beyond query.max_separation), a normal that is no
/// direction, a point_count below 0 or above query.max_points, or contact points that are not finite.
/// @param geometry,points the pair's own, nullptr where the query does not ask for them.
const char* broken_answer(const Query& query, PairStatus status, const PairGeometry* geometry,
                          const ContactPoint* points) noexcept;

/// Returns how what a backend says of itself breaks the contract, a literal; nullptr where it does not:
/// resolutions are >= 0, and but for that of depths finite.
const char* broken_capabilities(const Capabilities& of) noexcept;

/// Makes the broken answers of a batch `failed` and clears the geometry of those that carry none. Returns how
/// many were broken. @param first_broken,what the index and fault of the first of them; unchanged where none
/// is broken.
std::size_t settle_answers(const Query& query, std::size_t pairs, const NarrowphaseOutput& output,
                           std::size_t& first_broken, const char*& what) noexcept;

}  // namespace touchstone
