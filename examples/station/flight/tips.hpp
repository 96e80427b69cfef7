#pragma once

#include <string>
#include <vector>

#include "touchstone/examples/training_run/setting/setting.hpp"

namespace touchstone::station {

/// A jaw of an end effector: a link that a prismatic joint moves on it; its value grows as it closes.
struct Jaw {
  std::uint32_t value;   ///< joint value
  std::uint32_t object;  ///< in the scene
};

/// A frame that the hand may fly: an end of an arm, or a free object.
struct Tip {
  std::string name;    ///< of the link or the object
  std::uint32_t link;  ///< of the mechanism; training::kNone: a free object
  std::uint32_t object =
      0;           ///< that stands for the hand: of an arm, the last link with hexahedra on the way there
  Pose X_HT = {};  ///< the frame in that object
  std::vector<Jaw> jaws = {};
};

/// The first is the script's own; of its arm the other ends follow, which are links without hexahedra that
/// carry no further link and whose chain a joint moves that no hand holds.
/// @param walks of an arm that walks the base's own ends count, too.
std::vector<Tip> find_tips(const training::Setting& setting, bool walks = false);

}  // namespace touchstone::station
