#pragma once

#include <array>
#include <string_view>
#include <utility>

#include "touchstone/examples/compare_backends/names.hpp"

namespace touchstone::comparison {

/// How the times were taken, in words: name and definition. Written into results.json and onto the page.
inline constexpr std::array<std::pair<std::string_view, std::string_view>, 9> kTimingMethod = {{
    {"single", "through the interface, one pair a call: the median of the blocks' averages, and their 99%"},
    {"batch", "through the interface, many pairs a call"},
    {"raw",
     "a floor: the engine's own cheapest call, of those measured, on objects already posed and in the cache "
     "(the block was just run through once, untimed; beside it stands `cached`). ode: dBoxTouchesBox for the "
     "overlap and dBoxBox for the manifold of boxes, both on data in arrays (through geoms, whose poses lie "
     "scattered over the heap, the same call took four times as long, and dCollide longer still); dCollide "
     "for other hexahedra. bullet: btBoxBoxDetector for boxes. bullet on other hexahedra, and bullet_gjk: "
     "btGjkEpaSolver2::Distance (GJK without EPA) for the overlap, btGjkPairDetector with EPA for the rest. "
     "libccd: ccdGJKIntersect and ccdMPRIntersect on world vertices. fcl: fcl::collide, and fcl::distance "
     "for the distance. mujoco: the function of its own collision table for the pair's types, whatever is "
     "asked"},
    {"cached",
     "as single, on a block of pairs that was just run through once, untimed: the data are in the cache"},
    {"frame", "scenes: every pair of a frame in one call through the interface, a frame"},
    {"order",
     "the pairs are shuffled once, then streamed from memory, alike for every row but cached and raw: no "
     "other row finds its solids in the cache. Up to 16 pairs of the block before run first, untimed: they "
     "bring in the code"},
    {"shuffling",
     "backends, queries, modes and blocks run in one shuffled order, so that a machine that slows "
     "down slows all of them; rows slower than the time limit run fewer blocks"},
    {"worker",
     "bullet_single and bullet_single_gjk live in a process of their own (one process holds one precision "
     "of Bullet). It runs after the others, set by set, on the same pairs in the same shuffled order and "
     "with the same timing code: interleaved with the others by set, not by block"},
    {"allocations", "of the calling thread, per query, through malloc, after a warm-up"},
}};

}  // namespace touchstone::comparison
