#pragma once

#include <string_view>

#include "touchstone/examples/measures/paths/path_set.hpp"
#include "touchstone/examples/measures/truth/oracle.hpp"

namespace touchstone::measures {

/// Whether two solids meet on their paths.
enum class PathClass : std::uint8_t {
  clear,  ///< apart on the whole path, proven
  meets,
  open  ///< in contact from the start, or nearer than kProofGap S without a contact that was found: not
        ///< judged
};
/// The enumerator's name.
std::string_view to_string(PathClass path_class);

/// The truth about a path: a bracket of the time of impact. A contact that ends sooner than it is away from
/// lo may be looked past, and hi is then within a later one. In the frozen sets hi - lo < 1e-6.
struct PathTruth {
  PathClass path_class = PathClass::open;
  double lo = 1;  ///< apart on [0, lo]: proven by exact separations
  double hi = 1;  ///< in contact here, exactly, where it meets; 1 else

  friend bool operator==(const PathTruth&, const PathTruth&) = default;
};

/// The proof goes on until the two are this near [S].
inline constexpr double kProofGap = 0x1p-40;

/// One path: conservative advancement by exact separations up to kProofGap S, then exact poses beyond it.
/// @param exact built over the path's two solids.
PathTruth path_truth(const SolidPaths& paths, const Narrowphase& exact, const Oracle& oracle);

/// Of every path of the set, on `threads` threads. @pre `exact` is in this build.
std::vector<PathTruth> compute_path_truth(const PairSet& set, std::size_t poses, const Oracle& oracle,
                                          int threads);

}  // namespace touchstone::measures
