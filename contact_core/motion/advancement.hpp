#pragma once

#include <cstdint>
#include <optional>

namespace touchstone {

/// How conservative advancement ended.
enum class AdvanceEnd : std::uint8_t {
  answered,     ///< a look ended it
  looks_spent,  ///< no answer by the last look allowed, or none that lets it on: nothing is known beyond s
};

/// Conservative advancement (Mirtich 1996): looks at a motion, goes on as far as nothing can be missed, and
/// looks again there. find_impact(), find_sampled_impact() and physics' fast pairs use it with looks of their
/// own.
/// @param s where the first look is; at the end, where the last one was.
/// @param look look(s) returns where to look next, or none: it ends here, and the look keeps what it found.
template <class Look>
AdvanceEnd advance(double& s, int most_looks, Look look) {
  for (int looks = 1;; ++looks) {
    const std::optional<double> next = look(s);
    if (!next) return AdvanceEnd::answered;
    if (looks >= most_looks || !(*next > s)) return AdvanceEnd::looks_spent;
    s = *next;
  }
}

}  // namespace touchstone
