#include "touchstone/contact_core/world/pairs/pair_rules.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

bool is_empty(const PairRule& rule) {
  return !rule.policy && !rule.warn_distance && !rule.translation_only && !rule.passive;
}

/// Takes what is not set yet.
void inherit(PairRule& rule, const PairRule& from) {
  if (!rule.policy) rule.policy = from.policy;
  if (!rule.warn_distance) rule.warn_distance = from.warn_distance;
  if (!rule.translation_only) rule.translation_only = from.translation_only;
  if (!rule.passive) rule.passive = from.passive;
}

}  // namespace

void PairRules::check(const PairRule& rule) {
  const double warn = rule.warn_distance.value_or(0.0);
  if (!std::isfinite(warn) || warn < 0.0)
    throw InputError("contact world: a rule's warn distance is " + figure(warn) + " m, not a length");
}

void PairRules::note(const PairRule& rule) {
  moves_passive_ = moves_passive_ || rule.passive.value_or(Passive::stays) != Passive::stays;
  largest_warn_ = std::max(largest_warn_, rule.warn_distance.value_or(0.0));
}

void PairRules::set_default(const PairRule& rule) {
  check(rule), note(rule);
  default_ = rule;
}

void PairRules::set_for_groups(const ObjectTable& objects, std::uint32_t first, std::uint32_t second,
                               const PairRule& rule) {
  check(rule), note(rule);
  const std::pair key = std::minmax({first, second});
  const bool is_second_smaller =
      objects.members_of_group(key.second).size() < objects.members_of_group(key.first).size();
  std::erase_if(for_groups_, [&](const GroupEntry& entry) {
    return std::pair{entry.first, entry.second} == key;
  });
  if (!is_empty(rule))
    for_groups_.push_back({key.first, key.second, rule, is_second_smaller ? key.second : key.first});
}

PairRule PairRules::rule_of_groups(std::uint32_t first, std::uint32_t second) const {
  const std::pair key = std::minmax({first, second});
  for (const GroupEntry& entry : for_groups_)
    if (std::pair{entry.first, entry.second} == key) return entry.rule;
  return {};
}

// Multiplicative hashing (Knuth, The Art of Computer Programming 3, 6.4), folded so that all bits count.
std::size_t PairRules::home_of(const ObjectHandle& a, const ObjectHandle& b) const {
  constexpr std::uint64_t kFactor = 0x9e3779b97f4a7c15;
  const auto word = [](const ObjectHandle& object) {
    return std::uint64_t{object.slot} << 32 | object.generation;
  };
  std::uint64_t key = word(a) * kFactor;
  key = (key ^ (key >> 32) ^ word(b)) * kFactor;
  return static_cast<std::size_t>(key >> 32) & (for_pairs_.size() - 1);
}

std::size_t PairRules::place_of(const ObjectHandle& a, const ObjectHandle& b) const {
  if (used_ == 0) return kNone;
  std::size_t i = home_of(a, b);
  for (; !for_pairs_[i].is_free(); i = (i + 1) & (for_pairs_.size() - 1))
    if (for_pairs_[i].a == a && for_pairs_[i].b == b) return i;
  return kNone;
}

void PairRules::put(const PairEntry& entry) {
  std::size_t i = home_of(entry.a, entry.b);
  while (!for_pairs_[i].is_free()) i = (i + 1) & (for_pairs_.size() - 1);
  for_pairs_[i] = entry;
  ++used_;
}

/// Those behind it move up, as far as their homes let them.
void PairRules::take_out(std::size_t hole) {
  const std::size_t mask = for_pairs_.size() - 1;
  for (std::size_t i = (hole + 1) & mask; !for_pairs_[i].is_free(); i = (i + 1) & mask) {
    const std::size_t home = home_of(for_pairs_[i].a, for_pairs_[i].b);
    if (((i - home) & mask) < ((i - hole) & mask)) continue;
    for_pairs_[hole] = for_pairs_[i];
    hole = i;
  }
  for_pairs_[hole] = {};
  --used_;
}

/// For one more: rules of what is gone make room first.
void PairRules::make_room(const ObjectTable& objects) {
  if (2 * (used_ + 1) <= for_pairs_.size()) return;
  std::vector<PairEntry> kept;
  for (const PairEntry& entry : for_pairs_)
    if (!entry.is_free() && objects.is_alive(entry.a) && objects.is_alive(entry.b)) kept.push_back(entry);
  // At most a quarter full, so that the next time is far.
  std::size_t room = 16;
  while (room < 4 * (kept.size() + 1)) room *= 2;
  for_pairs_.assign(room, {});
  used_ = 0;
  for (const PairEntry& entry : kept) put(entry);
}

void PairRules::set_for_pair(const ObjectTable& objects, ObjectHandle a, ObjectHandle b,
                             const PairRule& rule) {
  check(rule), note(rule);
  if (b < a) std::swap(a, b);
  const std::size_t place = place_of(a, b);
  if (place != kNone) {
    if (is_empty(rule))
      take_out(place);
    else
      for_pairs_[place].rule = rule;
  } else if (!is_empty(rule)) {
    make_room(objects);
    put({a, b, rule});
  }
}

EffectiveRule PairRules::find(const ObjectTable& objects, std::uint32_t a, std::uint32_t b) const {
  PairRule rule;
  const std::pair key = std::minmax({a, b});
  const std::size_t place = place_of(objects.handle(key.first), objects.handle(key.second));
  if (place != kNone) rule = for_pairs_[place].rule;
  const std::uint64_t groups_a = objects[a].groups, groups_b = objects[b].groups;
  for (auto entry = for_groups_.rbegin(); entry != for_groups_.rend(); ++entry) {
    const bool straight = (groups_a >> entry->first & 1) && (groups_b >> entry->second & 1);
    const bool crossed = (groups_b >> entry->first & 1) && (groups_a >> entry->second & 1);
    if (straight || crossed) inherit(rule, entry->rule);
  }
  inherit(rule, default_);
  EffectiveRule out;
  out.policy = rule.policy.value_or(out.policy);
  out.warn_distance = rule.warn_distance.value_or(out.warn_distance);
  out.translation_only = rule.translation_only.value_or(out.translation_only);
  out.passive = rule.passive.value_or(out.passive);
  return out;
}

double PairRules::largest_group_warn_distance() const {
  double largest = 0.0;
  for (const GroupEntry& entry : for_groups_)
    largest = std::max(largest, entry.rule.warn_distance.value_or(0.0));
  return largest;
}

// A rule that a later one hides may show again when that one is set anew: all of them count.
double PairRules::reach_of(const ObjectTable& objects, std::uint32_t slot) const {
  double reach = 0.0;
  for (const GroupEntry& entry : for_groups_)
    if (objects[slot].groups >> entry.bearer & 1)
      reach = std::max(reach, entry.rule.warn_distance.value_or(0.0));
  return reach;
}

void PairRules::find_reaches(const ObjectTable& objects, std::span<double> by_slot) const {
  for (std::uint32_t slot = 0; slot < by_slot.size(); ++slot)
    by_slot[slot] = std::max(by_slot[slot], reach_of(objects, slot));
  for (const PairEntry& entry : for_pairs_)
    if (!entry.is_free() && objects.is_alive(entry.a) && objects.is_alive(entry.b))
      by_slot[entry.a.slot] = std::max(by_slot[entry.a.slot], entry.rule.warn_distance.value_or(0.0));
}

std::uint32_t PairRules::bearer_of(std::uint32_t first, std::uint32_t second) const {
  const std::pair key = std::minmax({first, second});
  for (const GroupEntry& entry : for_groups_)
    if (std::pair{entry.first, entry.second} == key) return entry.bearer;
  return key.first;
}

}  // namespace touchstone
