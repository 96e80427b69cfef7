#include "touchstone/contact_core/world/pairs/selection_state.hpp"

#include "touchstone/contact_core/geometry/no_index.hpp"

namespace touchstone {
namespace {

/// Puts `value` into a sorted list, or takes it out.
template <class T>
void set_member(std::vector<T>& list, const T& value, bool member) {
  const auto place = std::lower_bound(list.begin(), list.end(), value);
  const bool is_member = place != list.end() && *place == value;
  if (member && !is_member) list.insert(place, value);
  if (!member && is_member) list.erase(place);
}

}  // namespace

bool Selection::apply(const SelectionChange& change, const ObjectTable& objects,
                      const MechanismTable& mechanisms) {
  const auto [first, second] = std::pair{change.first, change.second};
  // A change that names an object, a group or a mechanism that does not exist is refused.
  switch (change.scope) {
    case SelectionChange::Scope::everything:
      everything_ = change.on;
      return true;
    case SelectionChange::Scope::object:
      if (!objects.is_alive(first)) return false;
      set_member(objects_off_, first.slot, !change.on);
      return true;
    case SelectionChange::Scope::pair:
      if (!objects.is_alive(first) || !objects.is_alive(second) || first == second) return false;
      set_member(pairs_off_, std::minmax({first.slot, second.slot}), !change.on);
      return true;
    case SelectionChange::Scope::group: {
      const auto group = objects.find_group(change.group.text());
      if (!group) return false;
      // A group is one bit of all that are off.
      const std::uint64_t bit = std::uint64_t{1} << *group;
      groups_off_ = change.on ? groups_off_ & ~bit : groups_off_ | bit;
      return true;
    }
    case SelectionChange::Scope::mechanism:
      if (!mechanisms.is_alive(change.mechanism)) return false;
      // A mechanism is switched by its links.
      for (const std::uint32_t slot : mechanisms.get(change.mechanism).slot_of_link)
        if (slot != kNoIndex) set_member(objects_off_, slot, !change.on);
      return true;
  }
  return false;
}

void Selection::forget(std::uint32_t slot) {
  std::erase(objects_off_, slot);
  std::erase_if(pairs_off_, [&](const auto& pair) { return pair.first == slot || pair.second == slot; });
}

bool Selection::is_on(const ObjectTable& objects, std::uint32_t a, std::uint32_t b) const {
  if (!everything_ || (objects[a].groups & groups_off_) || (objects[b].groups & groups_off_)) return false;
  const auto off = [&](std::uint32_t slot) {
    return std::binary_search(objects_off_.begin(), objects_off_.end(), slot);
  };
  return !off(a) && !off(b) && !std::binary_search(pairs_off_.begin(), pairs_off_.end(), std::minmax({a, b}));
}

}  // namespace touchstone
