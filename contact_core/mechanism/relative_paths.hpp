#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "touchstone/contact_core/mechanism/mechanism_path.hpp"

namespace touchstone {

/// A mechanism's path in the frame of each of its links: that link rests at its pose at s = 0, and the links
/// between it and the base move instead. Two links meet at the same s in every such view, but only joints
/// between the two count towards the bounds: an arm that swings with its outer part folded is known to be
/// clear of itself in one step. Only set-up allocates.
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
