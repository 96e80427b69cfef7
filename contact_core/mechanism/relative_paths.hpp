#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "touchstone/contact_core/mechanism/mechanism_path.hpp"

namespace touchstone {

/// A mechanism's path as each of its links sees it: the link stands still where it is at s = 0, and what lies
/// between it and the base moves instead. Two links meet at the same s in any of these, but only what turns
/// between the two counts towards the bounds: an arm that carries a folded part of itself round keeps clear
/// at once. set-up allocates, all else does not.
class RelativePaths {
 public:
  explicit RelativePaths(const Mechanism& mechanism);

  /// Starts on another path; paths that seen_from() returned before are void.
  void forget() noexcept;
  /// @param whole the path that is seen; the same between two calls of forget().
  const MechanismPath& seen_from(std::uint32_t link, const MechanismPath& whole) noexcept;

 private:
  struct Seen {
    std::unique_ptr<const Mechanism> mechanism;  // null: the base, which sees the path itself
    std::unique_ptr<MechanismPath> path;
    bool is_set = false;
  };
  std::vector<Seen> seen_;  // by link
};

}  // namespace touchstone
