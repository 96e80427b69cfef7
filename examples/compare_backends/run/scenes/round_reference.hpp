#pragma once

#include <span>
#include <vector>

#include "touchstone/examples/compare_backends/names.hpp"
#include "touchstone/examples/measures/pairs/pair_set.hpp"
#include "touchstone/examples/measures/truth/oracle.hpp"

/// @file
/// The clearance of round parts as they truly are, not of the facets that stand for them: a bracket from
/// sectors of the true tube, each enclosed by one hexahedron and enclosing another, halved where the
/// clearance is decided until the two agree.

namespace touchstone::comparison {

/// A round part of a scene: the points between two circles about its z axis. In a set it stands as
/// consecutive facets, all posed alike.
struct Tube {
  SolidIndex first = 0;  ///< of its facets
  std::size_t facets = 0;
  double outer_radius = 0, inner_radius = 0;  ///< of the true circles [m]
  double low = 0, high = 0;                   ///< along z, in the facets' frame [m]
  double offset = 0;  ///< how far the facets' surface is from the true one at most [m]
};

/// The true clearance of a frame lies within [low, high], to rounding of the coordinates.
struct ClearanceBracket {
  double low = 0, high = 0;  ///< [m]; in contact `low` is only a bound: a depth depends on how a part is cut

  bool contact() const { return high <= 0.0; }
  double middle() const { return 0.5 * (low + high); }
  double half_width() const { return 0.5 * (high - low); }
};

/// The width to which the bracket is narrowed where the frame is not in contact: a thousandth of the
/// smallest contact gap [m].
inline constexpr double kBracketWidth = 1e-12;

/// The least separation of one frame's pairs, with every tube as it truly is. A pair of a solid and a tube
/// counts where any of the tube's facets is paired with it. The bracket stays wider than kBracketWidth where
/// the least clearance is reached along a curve (a tube coaxial with another): after 20 000 exact answers it
/// is given as it is.
ClearanceBracket true_clearance(const PairSet& set, std::size_t frame, std::span<const Tube> tubes,
                                const Oracle& oracle);

}  // namespace touchstone::comparison
