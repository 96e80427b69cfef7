#include "touchstone/contact_core/world/pairs/pair_watch.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/memory/reserve_more.hpp"

namespace touchstone {

void PairWatch::reserve(std::size_t pairs) {
  reserve_more(pairs_, pairs), reserve_more(links_, 2 * pairs), reserve_more(free_, pairs);
  reserve_more(group_of_, pairs), reserve_more(in_group_, pairs);
}

void PairWatch::set_solids(std::size_t solids) {
  if (solids == first_.size()) return;
  resize_more(first_, solids, kNoIndex), resize_more(group_of_solid_, solids, kNoIndex);
  reserve_more(groups_, solids + group_of_link_pair_.size() + 1);
}

void PairWatch::set_link_pairs(std::size_t count) {
  if (count <= group_of_link_pair_.size()) return;
  resize_more(group_of_link_pair_, count, kNoIndex);
  reserve_more(groups_, group_of_solid_.size() + count + 1);
}

void PairWatch::clear() {
  pairs_.clear(), links_.clear(), free_.clear();
  std::fill(first_.begin(), first_.end(), kNoIndex);
  count_ = 0;
  groups_.clear(), group_of_.clear(), in_group_.clear();
  for (GrowingList<std::uint32_t>* of : {&group_of_solid_, &group_of_link_pair_})
    std::fill(of->begin(), of->end(), kNoIndex);
  group_of_two_movers_ = kNoIndex;
}

void PairWatch::put_in(std::uint32_t place, SolidIndex solid) {
  const std::uint32_t next = first_[solid];
  links_[place] = {next, kNoIndex};
  if (next != kNoIndex) links_[next].previous = place;
  first_[solid] = place;
}

void PairWatch::take_out(std::uint32_t place, SolidIndex solid) {
  const auto [next, previous] = links_[place];
  if (next != kNoIndex) links_[next].previous = previous;
  (previous != kNoIndex ? links_[previous].next : first_[solid]) = next;
}

std::uint32_t PairWatch::add(const WatchedPair& pair) {
  std::uint32_t index = size();
  if (free_.empty()) {
    pairs_.push_back(pair);
    links_.resize(2 * pairs_.size());
    group_of_.push_back(kNoIndex), in_group_.push_back({kNoIndex, kNoIndex, 0.0});
  } else {
    index = free_.back();
    free_.pop_back();
    pairs_[index] = pair;
  }
  put_in(2 * index, pair.a);
  put_in(2 * index + 1, pair.b);
  ++count_;
  return index;
}

std::uint32_t PairWatch::add_of_arm(const WatchedPair& pair, SolidIndex moving, double gone) {
  const std::uint32_t index = add(pair);
  put_in_group(index, group_for(pair, moving), moving == kNoIndex ? 0.0 : gone);
  return index;
}

void PairWatch::note_moves(SolidIndex solid) {
  for_each_of(solid, [&](std::uint32_t index) {
    if (group_of_[index] == kNoIndex || pairs_[index].link_pair != kNoLinkPair) return;
    take_out_of_group(index);
    put_in_group(index, group_for(pairs_[index], kNoIndex), 0.0);
  });
}

void PairWatch::note_rests(SolidIndex solid, double gone) {
  for_each_of(solid, [&](std::uint32_t index) {
    const WatchedPair& pair = pairs_[index];
    if (group_of_[index] == kNoIndex || pair.link_pair != kNoLinkPair) return;
    take_out_of_group(index);
    put_in_group(index, group_for(pair, pair.a == solid ? pair.b : pair.a), gone);
  });
}

void PairWatch::put_in_group(std::uint32_t index, std::uint32_t place, double gone) {
  ArmGroup& group = groups_[place];
  // What moves may have begun anew since the last pair left.
  if (group.near == kNoIndex && group.far == kNoIndex) group.most_gone = 0.0, group.least_left = kInfinity;
  group_of_[index] = place;
  in_group_[index].gone = gone * (1.0 + kRounding);
  const double left = left_for_mover(index);
  if (group.travels_apart || left <= group.most_gone) {
    hang(index, group.near);
  } else {
    hang(index, group.far);
    group.least_left = std::min(group.least_left, left);
  }
}

void PairWatch::hang(std::uint32_t index, std::uint32_t& list) {
  in_group_[index].next = list, in_group_[index].previous = kNoIndex;
  if (list != kNoIndex) in_group_[list].previous = index;
  list = index;
}

void PairWatch::unhang(std::uint32_t index) {
  const auto [next, previous, gone] = in_group_[index];
  ArmGroup& group = groups_[group_of_[index]];
  if (next != kNoIndex) in_group_[next].previous = previous;
  if (previous != kNoIndex)
    in_group_[previous].next = next;
  else
    (group.near == index ? group.near : group.far) = next;
}

/// Of the far pairs those that are no longer clear up to most_gone.
void PairWatch::take_near(ArmGroup& group) {
  double least = kInfinity;
  for (std::uint32_t index = group.far; index != kNoIndex;) {
    const std::uint32_t next = in_group_[index].next;
    const double left = left_for_mover(index);
    if (left > group.most_gone)
      least = std::min(least, left);
    else
      unhang(index), hang(index, group.near);
    index = next;
  }
  group.least_left = least;
}

/// A near pair that has turned out to be clear for longer.
void PairWatch::take_far(std::uint32_t index) {
  ArmGroup& group = groups_[group_of_[index]];
  if (group.travels_apart) return;
  unhang(index), hang(index, group.far);
  group.least_left = std::min(group.least_left, left_for_mover(index));
}

std::uint32_t PairWatch::group_for(const WatchedPair& pair, SolidIndex moving) {
  if (pair.link_pair != kNoLinkPair) set_link_pairs(pair.link_pair + 1);
  std::uint32_t& place = pair.link_pair != kNoLinkPair ? group_of_link_pair_[pair.link_pair]
                         : moving != kNoIndex          ? group_of_solid_[moving]
                                                       : group_of_two_movers_;
  if (place == kNoIndex) {
    place = static_cast<std::uint32_t>(groups_.size());
    groups_.emplace_back();
    groups_.back().travels_apart = pair.link_pair == kNoLinkPair && moving == kNoIndex;
  }
  return place;
}

void PairWatch::take_out_of_group(std::uint32_t index) {
  if (group_of_[index] == kNoIndex) return;
  unhang(index);
  group_of_[index] = kNoIndex;
}

void PairWatch::remove(std::uint32_t index) {
  take_out_of_group(index);
  take_out(2 * index, pairs_[index].a);
  take_out(2 * index + 1, pairs_[index].b);
  pairs_[index] = {0, 0, kNoLinkPair, kForever};
  free_.push_back(index);
  --count_;
}

// A sum less its rounding, so that any number of calls leaves pairs clear for no longer than they are.
void PairWatch::shorten_clearances(double by) {
  for (WatchedPair& pair : pairs_)
    if (pair.clear_until < kForever)
      pair.clear_until = (pair.clear_until - by) - 0x1p-50 * std::abs(pair.clear_until);
  for (ArmGroup& group : groups_) group.least_left = -kInfinity;  // none is known to be far
}

std::uint32_t PairWatch::find(const SolidPair& pair) const {
  for (std::uint32_t place = first_[pair.a]; place != kNoIndex; place = links_[place].next)
    if (place % 2 == 0 && pairs_[place / 2].b == pair.b) return place / 2;
  return kNoIndex;
}

}  // namespace touchstone
