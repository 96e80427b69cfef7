#include "touchstone/contact_core/world/pair_rules.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

std::pair<std::uint32_t, std::uint32_t> ordered(std::uint32_t a, std::uint32_t b) {
  return a < b ? std::pair{a, b} : std::pair{b, a};
}

bool is_empty(const PairRule& rule) { return !rule.policy && !rule.warn_distance && !rule.translation_only; }

/// Takes what is not set yet.
void inherit(PairRule& rule, const PairRule& from) {
  if (!rule.policy) rule.policy = from.policy;
  if (!rule.warn_distance) rule.warn_distance = from.warn_distance;
  if (!rule.translation_only) rule.translation_only = from.translation_only;
}

}  // namespace

void PairRules::check(const PairRule& rule) {
  const double warn = rule.warn_distance.value_or(0.0);
  if (!std::isfinite(warn) || warn < 0.0)
    throw InputError("contact world: a rule's warn distance is " + figure(warn) + " m, not a length");
}

void PairRules::set_default(const PairRule& rule) {
  check(rule);
  default_ = rule;
}

void PairRules::set_for_groups(std::uint32_t first, std::uint32_t second, const PairRule& rule) {
  check(rule);
  const std::pair key = ordered(first, second);
  std::erase_if(for_groups_, [&](const Entry& entry) { return std::pair{entry.first, entry.second} == key; });
  if (!is_empty(rule)) for_groups_.push_back({key.first, key.second, rule});
}

void PairRules::set_for_pair(std::uint32_t a, std::uint32_t b, const PairRule& rule) {
  check(rule);
  const std::pair key = ordered(a, b);
  const auto before = [](const Entry& entry, const std::pair<std::uint32_t, std::uint32_t>& wanted) {
    return std::pair{entry.first, entry.second} < wanted;
  };
  const auto place = std::lower_bound(for_pairs_.begin(), for_pairs_.end(), key, before);
  const bool is_there = place != for_pairs_.end() && std::pair{place->first, place->second} == key;
  if (is_empty(rule)) {
    if (is_there) for_pairs_.erase(place);
  } else if (is_there) {
    place->rule = rule;
  } else {
    for_pairs_.insert(place, {key.first, key.second, rule});
  }
}

void PairRules::forget(std::uint32_t slot) {
  std::erase_if(for_pairs_, [&](const Entry& entry) { return entry.first == slot || entry.second == slot; });
}

EffectiveRule PairRules::find(const ObjectTable& objects, std::uint32_t a, std::uint32_t b) const {
  PairRule rule;
  const std::pair key = ordered(a, b);
  const auto place =
      std::lower_bound(for_pairs_.begin(), for_pairs_.end(), key, [](const Entry& entry, const auto& wanted) {
        return std::pair{entry.first, entry.second} < wanted;
      });
  if (place != for_pairs_.end() && std::pair{place->first, place->second} == key) rule = place->rule;
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
  return out;
}

double PairRules::largest_warn_distance() const {
  double largest = default_.warn_distance.value_or(0.0);
  for (const std::vector<Entry>* list : {&for_groups_, &for_pairs_})
    for (const Entry& entry : *list) largest = std::max(largest, entry.rule.warn_distance.value_or(0.0));
  return largest;
}

}  // namespace touchstone
