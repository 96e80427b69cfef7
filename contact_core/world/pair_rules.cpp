#include "touchstone/contact_core/world/pair_rules.hpp"

namespace touchstone {
namespace {

std::pair<std::uint32_t, std::uint32_t> ordered(std::uint32_t a, std::uint32_t b) {
  return a < b ? std::pair{a, b} : std::pair{b, a};
}

/// Puts `value` into a sorted list, or takes it out.
template <class T>
void set_member(std::vector<T>& list, const T& value, bool member) {
  const auto place = std::lower_bound(list.begin(), list.end(), value);
  const bool is_member = place != list.end() && *place == value;
  if (member && !is_member) list.insert(place, value);
  if (!member && is_member) list.erase(place);
}

}  // namespace

void PairRules::set_for_pair(std::uint32_t a, std::uint32_t b, const PairRule& rule) {
  const auto [first, second] = ordered(a, b);
  const auto before = [](const Entry& entry, const std::pair<std::uint32_t, std::uint32_t>& key) {
    return std::pair{entry.first, entry.second} < key;
  };
  const auto place = std::lower_bound(for_pairs_.begin(), for_pairs_.end(), std::pair{first, second}, before);
  if (place != for_pairs_.end() && place->first == first && place->second == second)
    place->rule = rule;
  else
    for_pairs_.insert(place, {first, second, rule});
}

void PairRules::forget(std::uint32_t slot) {
  std::erase_if(for_pairs_, [&](const Entry& entry) { return entry.first == slot || entry.second == slot; });
}

const PairRule& PairRules::find(const ObjectTable& objects, std::uint32_t a, std::uint32_t b) const {
  const auto key = ordered(a, b);
  const auto place =
      std::lower_bound(for_pairs_.begin(), for_pairs_.end(), key, [](const Entry& entry, const auto& wanted) {
        return std::pair{entry.first, entry.second} < wanted;
      });
  if (place != for_pairs_.end() && std::pair{place->first, place->second} == key) return place->rule;
  const std::uint64_t groups_a = objects[a].groups, groups_b = objects[b].groups;
  for (auto entry = for_groups_.rbegin(); entry != for_groups_.rend(); ++entry) {
    const bool straight = (groups_a >> entry->first & 1) && (groups_b >> entry->second & 1);
    const bool crossed = (groups_b >> entry->first & 1) && (groups_a >> entry->second & 1);
    if (straight || crossed) return entry->rule;
  }
  return default_;
}

double PairRules::largest_warn_distance() const {
  double largest = default_.warn_distance;
  for (const Entry& entry : for_groups_) largest = std::max(largest, entry.rule.warn_distance);
  for (const Entry& entry : for_pairs_) largest = std::max(largest, entry.rule.warn_distance);
  return largest;
}

void Selection::apply(const SelectionChange& change) {
  switch (change.scope) {
    case SelectionChange::Scope::everything:
      everything_ = change.on;
      break;
    case SelectionChange::Scope::object:
      set_member(objects_off_, change.first, !change.on);
      break;
    case SelectionChange::Scope::pair:
      set_member(pairs_off_, ordered(change.first, change.second), !change.on);
      break;
    case SelectionChange::Scope::group:
      if (change.first < 64)
        groups_off_ = change.on ? groups_off_ & ~(std::uint64_t{1} << change.first)
                                : groups_off_ | std::uint64_t{1} << change.first;
      break;
  }
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
  return !off(a) && !off(b) && !std::binary_search(pairs_off_.begin(), pairs_off_.end(), ordered(a, b));
}

}  // namespace touchstone
