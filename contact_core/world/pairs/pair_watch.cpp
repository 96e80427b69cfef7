#include "touchstone/contact_core/world/pairs/pair_watch.hpp"

#include <algorithm>

#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/memory/reserve_more.hpp"

namespace touchstone {

void PairWatch::reserve(std::size_t pairs) {
  reserve_more(pairs_, pairs), reserve_more(links_, 2 * pairs), reserve_more(free_, pairs);
}

void PairWatch::set_solids(std::size_t solids) {
  if (solids != first_.size()) resize_more(first_, solids, kNoIndex);
}

void PairWatch::clear() {
  pairs_.clear(), links_.clear(), free_.clear();
  std::fill(first_.begin(), first_.end(), kNoIndex);
  count_ = 0;
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

void PairWatch::remove(std::uint32_t index) {
  take_out(2 * index, pairs_[index].a);
  take_out(2 * index + 1, pairs_[index].b);
  pairs_[index] = {0, 0, kNoLinkPair, kForever};
  free_.push_back(index);
  --count_;
}

std::uint32_t PairWatch::find(const SolidPair& pair) const {
  for (std::uint32_t place = first_[pair.a]; place != kNoIndex; place = links_[place].next)
    if (place % 2 == 0 && pairs_[place / 2].b == pair.b) return place / 2;
  return kNoIndex;
}

}  // namespace touchstone
