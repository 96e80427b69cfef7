#include "touchstone/contact_core/world/frame/watched_pairs.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "touchstone/contact_core/world/model/reserve_more.hpp"

namespace touchstone {
namespace {

/// Solids may go this many times as far as on the path at hand, and this share of their radius, before the
/// broadphase is asked again.
constexpr double kReserveFrames = 8.0;
constexpr double kReserveRadius = 0.125;
/// The same of the imminent ones of the watched pairs.
constexpr double kImminentFrames = 1.0;
constexpr double kImminentRadius = 0x1p-6;
/// The same factor for what slides ask.
constexpr double kReserveNeeds = 1.5;
/// Of more objects than one in this many the pairs are found together with all others.
constexpr std::size_t kWatchAll = 4;
/// Rounding of bounds.
constexpr double kUp = 1.0 + 0x1p-20;

bool may_be_watched(const WorldModel& model, const SolidPair& pair) {
  const ObjectTable& objects = model.objects;
  const Layout& layout = model.layout;
  const std::uint32_t a = layout.slot_of[pair.a], b = layout.slot_of[pair.b];
  if (!layout.is_alive(a) || !layout.is_alive(b)) return false;
  if (objects[a].body == objects[b].body || (objects[a].is_static() && objects[b].is_static())) return false;
  return !layout.is_exempt(pair);
}

/// Clear where it stood before the path that is laid.
bool is_clear_before(const WorldModel& model, const WatchedPair& watch) {
  const SolidPair pair{watch.a, watch.b};
  return model.travelled(pair, watch.link_pair) - model.last_travel(pair, watch.link_pair) <=
         watch.clear_until;
}

}  // namespace

void WatchedPairs::take_room(const WorldModel& model, bool anew) {
  const std::size_t slots = model.layout.slots(), solids = model.layout.solids.size();
  const auto size = [&](auto& list, std::size_t count) {
    if (anew) list.clear();
    resize_more(list, count);
  };
  size(is_noted_due_, slots), size(is_looked_at_, slots), size(reaches_, slots), size(regions_, solids);
  resize_more(stands_, solids);
  reserve_more(due_, slots), reserve_more(moved_, slots), reserve_more(movable_, slots);
  reserve_more(looked_at_, slots);
  if (pairs_.capacity() < 256 + 64 * solids) {
    const std::size_t room = 2 * (256 + 64 * solids);  // as reserve_more() has it
    pairs_.reserve(room), pairs_before_.reserve(room);
    for (std::vector<std::uint32_t>* indices : {&imminent_, &unclear_, &taken_}) indices->reserve(room);
    gathered_.reserve(room), is_taken_.reserve(room);
  }
  pairs_.set_solids(solids), pairs_before_.set_solids(solids);
  reserve_more(partners_, solids), reserve_more(known_partners_, solids);
}

bool WatchedPairs::begin(const WorldModel& model, Broadphase& broadphase) {
  reaches_.assign(model.layout.slots(), 0.0);
  model.rules.find_reaches(model.objects, reaches_);
  early_reaches_.clear();
  moved_.clear(), due_.clear(), unclear_.clear();
  pairs_.clear();
  pairs_.set_solids(model.layout.solids.size());
  needs_watch_ = needs_imminent_ = true;
  for (std::uint32_t slot = 0; slot < model.layout.slots(); ++slot) place(model, slot);
  return broadphase.update_paths({model.from, stands_, regions_}, {});
}

void WatchedPairs::begin_object(const WorldModel& model, std::uint32_t slot) {
  reaches_[slot] = model.layout.is_alive(slot) ? model.rules.reach_of(model.objects, slot) : 0.0;
  place(model, slot);
  if (model.layout.is_alive(slot)) watch_anew(model, slot);
}

/// The slot's object stands where the model has it, at rest.
void WatchedPairs::place(const WorldModel& model, std::uint32_t slot) {
  for (SolidIndex i = model.layout.first_solid[slot]; i < model.layout.first_solid[slot + 1]; ++i) {
    stands_[i] = model.from[i];
    regions_[i] = reaches_[slot] + model.contact_reach(i, 0.0);
  }
}

void WatchedPairs::forget(const WorldModel& model, std::uint32_t slot) {
  for (SolidIndex i = model.layout.first_solid[slot]; i < model.layout.first_solid[slot + 1]; ++i)
    pairs_.for_each_of(i, [&](std::uint32_t index) { pairs_.remove(index); });
  needs_imminent_ = true;
}

void WatchedPairs::watch_anew(const WorldModel& model, std::uint32_t slot) {
  forget(model, slot);
  note_due(slot);
}

bool WatchedPairs::raise_reach(const WorldModel& model, std::uint32_t slot, double warn) {
  const Layout& layout = model.layout;
  const ObjectHandle object = model.objects.handle(slot);
  if (slot >= layout.slots() || layout.handles[slot] != object) {  // it comes with the next frame
    early_reaches_.push_back({object, warn});
    return early_reaches_.size() <= TableChanges::kMostExemptions;
  }
  reaches_[slot] = std::max(reaches_[slot], warn);
  watch_anew(model, slot);
  return true;
}

void WatchedPairs::take_up_early_reaches(const ObjectTable& objects) {
  for (const auto& [object, warn] : early_reaches_)
    if (objects.is_alive(object)) reaches_[object.slot] = std::max(reaches_[object.slot], warn);
  early_reaches_.clear();
}

void WatchedPairs::begin_frame(WorldModel& model) {
  if (!is_overflown_) return;
  is_overflown_ = false;
  std::fill(model.travels.of_solid.begin(), model.travels.of_solid.end(), 0.0);
  std::fill(model.travels.of_link_pair.begin(), model.travels.of_link_pair.end(), 0.0);
  pairs_.clear();
  needs_watch_ = true;
}

void WatchedPairs::lay_paths(WorldModel& model, std::span<const std::uint32_t> roots) {
  const Layout& layout = model.layout;
  for (const std::uint32_t slot : moved_)
    for (SolidIndex solid = layout.first_solid[slot]; solid < layout.first_solid[slot + 1]; ++solid)
      model.travels.last_solid[solid] = 0.0;
  moved_.clear();
  std::fill(model.travels.last_link_pair.begin(), model.travels.last_link_pair.end(), 0.0);
  for (const std::uint32_t root : roots)
    if (model.in_motion[root]) lay_travels(model, root);
  std::sort(moved_.begin(), moved_.end());
}

void WatchedPairs::lay_travels(WorldModel& model, std::uint32_t root) {
  const Layout& layout = model.layout;
  model.for_each_member(root, [&](std::uint32_t slot) {
    if (!model.moves(slot)) return;
    moved_.push_back(slot);
    const BodyState start = model.state_at(slot, 0.0);
    for (SolidIndex solid = layout.first_solid[slot]; solid < layout.first_solid[slot + 1]; ++solid)
      lay_travel(model, solid, start);
  });
  if (const MechanismMover* mover = model.mechanism_of(root)) lay_link_travels(model, *mover);
}

void WatchedPairs::lay_travel(WorldModel& model, SolidIndex solid, const BodyState& start) {
  Travels& travels = model.travels;
  const Sphere& sphere = model.layout.solids[solid].bounding_sphere();
  const std::uint32_t slot = model.layout.slot_of[solid];
  if (const MechanismMover* mover = model.arm_of(slot)) {
    const bool is_planned = model.mechanism_of(slot) != nullptr && model.has_planned(*mover);
    travels.last_solid[solid] = is_planned ? travels.planned_solid[solid] : model.travel_on(*mover, solid);
  } else {
    const double arm = norm(transform(model.from[solid], sphere.centre) - start.centre_W) + sphere.radius;
    travels.last_solid[solid] = (norm(start.velocity_W) + norm(start.angular_velocity_W) * arm) * kUp;
  }
  travels.of_solid[solid] = Travels::sum(travels.of_solid[solid], travels.last_solid[solid]);
  if (!(travels.of_solid[solid] <= travels.solid_limit[solid])) note_due(slot);
  is_overflown_ = is_overflown_ || !(travels.of_solid[solid] <= Travels::kMost);
  needs_imminent_ = needs_imminent_ || !(travels.of_solid[solid] <= travels.imminent_solid[solid]);
}

void WatchedPairs::lay_link_travels(WorldModel& model, const MechanismMover& mover) {
  Travels& travels = model.travels;
  const auto links = static_cast<std::uint32_t>(mover.X_WL.size());
  if (model.has_planned(mover)) {
    const auto planned = travels.planned_link_pair.begin() + mover.first_link_pair;
    std::copy(planned, planned + links * links, travels.last_link_pair.begin() + mover.first_link_pair);
  } else {
    model.measure_link_travels(mover, travels.last_link_pair);
  }
  const std::size_t begin = mover.first_link_pair, end = begin + links * links;
  for (std::size_t k = begin; k < end; ++k)
    travels.of_link_pair[k] = Travels::sum(travels.of_link_pair[k], travels.last_link_pair[k]),
    needs_imminent_ = needs_imminent_ || !(travels.of_link_pair[k] <= travels.imminent_link_pair[k]),
    is_overflown_ = is_overflown_ || !(travels.of_link_pair[k] <= Travels::kMost);
}

/// Rates are bounded, so that up to s a mover goes s times as far at most. A sum less its last term is not
/// below the sum before: see Travels::sum().
void WatchedPairs::take_back(WorldModel& model, std::uint32_t root) const {
  Travels& travels = model.travels;
  const auto shorten = [&](double& sum, double& last) {
    const double gone = last * model.stops[root];
    sum = (sum - last) + gone;
    last = gone;
  };
  model.for_each_solid(
      root, [&](SolidIndex solid) { shorten(travels.of_solid[solid], travels.last_solid[solid]); });
  const MechanismMover* mover = model.mechanism_of(root);
  if (mover == nullptr) return;
  const std::size_t links = mover->X_WL.size();
  const std::size_t begin = mover->first_link_pair, end = begin + links * links;
  for (std::size_t k = begin; k < end; ++k) shorten(travels.of_link_pair[k], travels.last_link_pair[k]);
}

void WatchedPairs::note_due(std::uint32_t slot) {
  if (is_noted_due_[slot] != 0) return;
  is_noted_due_[slot] = 1;
  due_.push_back(slot);
}

/// Of all objects, or of those only that went beyond their limits or are new here.
void WatchedPairs::update(WorldModel& model, Broadphase& broadphase) {
  std::erase_if(due_, [&](std::uint32_t slot) {
    if (model.layout.is_alive(slot)) return false;
    is_noted_due_[slot] = 0;
    return true;
  });
  const bool all = needs_watch_ || kWatchAll * due_.size() > model.layout.slots();
  if (all || !update_due(model, broadphase)) update_all(model, broadphase);
  for (const std::uint32_t slot : due_) is_noted_due_[slot] = 0;
  due_.clear();
  needs_watch_ = false;
  needs_imminent_ = true;
}

/// Where the object's solids may be until its pairs are found anew.
void WatchedPairs::set_region(WorldModel& model, std::uint32_t slot) {
  Travels& travels = model.travels;
  const Layout& layout = model.layout;
  const bool is_static = layout.is_static[slot] != 0;
  for (SolidIndex solid = layout.first_solid[slot]; solid < layout.first_solid[slot + 1]; ++solid) {
    const double radius = layout.solids[solid].bounding_sphere().radius;
    const double usual = kReserveFrames * travels.last_solid[solid] + kReserveRadius * radius;
    const double reserve = is_static ? 0.0 : std::max(usual, kReserveNeeds * travels.needed[solid]);
    stands_[solid] = model.from[solid];
    regions_[solid] = (reserve + reaches_[slot] + model.contact_reach(solid, reserve)) * kUp;
    // The path at hand is counted already, but not gone yet.
    travels.solid_limit[solid] = travels.of_solid[solid] - travels.last_solid[solid] * kUp + reserve;
  }
}

/// @returns false where the broadphase knows all pairs only.
bool WatchedPairs::update_due(WorldModel& model, Broadphase& broadphase) {
  const Layout& layout = model.layout;
  std::sort(due_.begin(), due_.end());
  for (const std::uint32_t slot : due_) set_region(model, slot);
  broadphase.update_paths({stands_, stands_, regions_}, due_);
  for (const std::uint32_t slot : due_)
    for (SolidIndex solid = layout.first_solid[slot]; solid < layout.first_solid[slot + 1]; ++solid)
      if (!update_partners(model, broadphase, solid)) return false;
  return true;
}

/// Keeps the data of pairs that are watched already.
bool WatchedPairs::update_partners(const WorldModel& model, Broadphase& broadphase, SolidIndex solid) {
  partners_.clear(), known_partners_.clear();
  if (!broadphase.find_partners(solid, partners_)) return false;
  pairs_.for_each_of(solid, [&](std::uint32_t index) {
    const SolidPair pair = pairs_.solids(index);
    known_partners_.emplace_back(pair.a == solid ? pair.b : pair.a, index);
  });
  std::sort(partners_.begin(), partners_.end());
  std::sort(known_partners_.begin(), known_partners_.end());
  auto before = known_partners_.begin();
  const auto end = known_partners_.end();
  for (const SolidIndex other : partners_) {
    for (; before != end && before->first < other; ++before) pairs_.remove(before->second);
    if (before != end && before->first == other) {
      ++before;
      continue;
    }
    const SolidPair pair{std::min(solid, other), std::max(solid, other)};
    if (may_be_watched(model, pair))
      unclear_.push_back(pairs_.add({pair.a, pair.b, model.link_pair_index(pair), kNotKnown}));
  }
  for (; before != end; ++before) pairs_.remove(before->second);
  return true;
}

void WatchedPairs::update_all(WorldModel& model, Broadphase& broadphase) {
  const Layout& layout = model.layout;
  // Objects that may move get the region that they can reach before the next update.
  movable_.clear();
  for (std::uint32_t slot = 0; slot < layout.slots(); ++slot) {
    if (!layout.is_alive(slot)) continue;
    if (layout.is_static[slot] != 0 && is_noted_due_[slot] == 0 && reaches_[slot] == 0.0) continue;
    set_region(model, slot);
    movable_.push_back(slot);
  }
  broadphase.update_paths({stands_, stands_, regions_}, movable_);
  // The list is rebuilt from the broadphase's pairs.
  std::swap(pairs_before_, pairs_);
  pairs_.clear();
  pairs_.set_solids(layout.solids.size());
  unclear_.clear();
  PairCursor cursor;
  std::array<SolidPair, 256> block;
  while (!cursor.done) {
    const std::size_t count = broadphase.find_pairs(cursor, block);
    for (const SolidPair& pair : std::span(block).first(count)) {
      if (!may_be_watched(model, pair)) continue;
      WatchedPair watch{pair.a, pair.b, model.link_pair_index(pair), kNotKnown};
      // A pair that was watched before keeps what is known of it.
      const std::uint32_t before = pairs_before_.find(pair);
      if (before != PairWatch::kNone)
        watch.clear_until = pairs_before_[before].clear_until, watch.axis_W = pairs_before_[before].axis_W;
      unclear_.push_back(pairs_.add(watch));
    }
  }
}

/// Most watched pairs stay out of reach for many frames: those that may not are found now and then.
void WatchedPairs::choose_imminent(WorldModel& model) {
  Travels& travels = model.travels;
  const Layout& layout = model.layout;
  // A solid's limit is what it has travelled and may travel within a few frames.
  for (SolidIndex solid = 0; solid < layout.solids.size(); ++solid)
    if (layout.is_static[layout.slot_of[solid]] == 0)
      travels.imminent_solid[solid] = travels.of_solid[solid] + kImminentFrames * travels.last_solid[solid] +
                                      2.0 * travels.planned_solid[solid] +
                                      kImminentRadius * layout.solids[solid].bounding_sphere().radius;
  // The same holds for links relative to each other.
  for (std::uint32_t i = 0; i < model.mechanisms.size(); ++i) {
    const MechanismMover* mover = model.mechanisms.at(i);
    if (mover == nullptr) continue;
    const std::size_t links = mover->X_WL.size();
    for (std::size_t k = 0; k < links * links; ++k) {
      const std::size_t link_pair = mover->first_link_pair + k;
      travels.imminent_link_pair[link_pair] =
          travels.of_link_pair[link_pair] + kImminentFrames * travels.last_link_pair[link_pair] +
          2.0 * travels.planned_link_pair[link_pair] + kImminentRadius * mover->radius_of_link[k % links];
    }
  }
  // Pairs that are clear beyond these limits are not imminent.
  imminent_.clear();
  for (std::uint32_t i = 0; i < pairs_.size(); ++i) {
    const WatchedPair& watch = pairs_[i];
    const double limit = watch.link_pair != kNoLinkPair
                             ? travels.imminent_link_pair[watch.link_pair]
                             : travels.imminent_solid[watch.a] + travels.imminent_solid[watch.b];
    if (!(limit <= watch.clear_until)) imminent_.push_back(i);
  }
  needs_imminent_ = false;
}

/// Roots that move or have moved since, but for arms: of their many pairs those that are imminent are fewer.
void WatchedPairs::find_looked_at(const WorldModel& model, const Movers& movers) {
  looked_at_.clear();
  for (const std::vector<std::uint32_t>* roots : {&movers.commanded, &movers.commanded_before})
    for (const std::uint32_t root : *roots) {
      if (is_looked_at_[root] || model.mechanism_of(root) != nullptr) continue;
      is_looked_at_[root] = 1;
      looked_at_.push_back(root);
    }
}

/// Those of what moves, or has moved since, and those that were not clear before. Pairs that are off are
/// kept: when they are switched on they may have come near.
void WatchedPairs::gather(WorldModel& model, const Movers& movers, FrameLanes& lanes,
                          std::vector<std::uint32_t>& close, std::vector<std::uint32_t>& deferred) {
  constexpr std::size_t kRootsAtOnce = 16;
  find_looked_at(model, movers);
  const bool has_links = model.mechanisms.size() > 0;
  if (has_links && needs_imminent_) choose_imminent(model);
  // Each list gets room for all pairs, as lanes append to it.
  const auto make_room = [&](auto& list) { list.resize(std::max(list.size(), std::size_t{pairs_.size()})); };
  make_room(taken_), make_room(is_taken_);
  std::atomic<std::size_t> count{0};
  const auto take = [&](std::uint32_t i) {
    if (!model.is_clear(pairs_[i])) taken_[count.fetch_add(1, std::memory_order_relaxed)] = i;
  };
  // A pair of two roots that are looked at comes from its a.
  lanes.for_each(looked_at_.size(), kRootsAtOnce, [&](NarrowphaseQuery&, std::size_t i) {
    model.for_each_solid(looked_at_[i], [&](SolidIndex solid) {
      pairs_.for_each_of(solid, [&](std::uint32_t index) {
        if (pairs_[index].a == solid || !is_looked_at_[model.root_of(pairs_[index].a)]) take(index);
      });
    });
  });
  // Pairs that were not clear before, and those of links that are imminent, are added once.
  const auto take_once = [&](std::uint32_t i) {
    if (is_taken_[i] || model.is_clear(pairs_[i])) return;
    if (is_looked_at_[model.root_of(pairs_[i].a)] || is_looked_at_[model.root_of(pairs_[i].b)]) return;
    is_taken_[i] = 1;
    take(i);
  };
  const std::array<std::span<const std::uint32_t>, 2> others{
      unclear_, has_links ? std::span<const std::uint32_t>(imminent_) : std::span<const std::uint32_t>()};
  for (const std::span<const std::uint32_t> list : others) std::for_each(list.begin(), list.end(), take_once);
  // The marks are cleared, and pairs that were clear before this frame's motion are deferred.
  for (const std::uint32_t root : looked_at_) is_looked_at_[root] = 0;
  close.clear(), deferred.clear();
  unclear_.assign(taken_.begin(), taken_.begin() + static_cast<std::ptrdiff_t>(count));
  for (const std::uint32_t i : unclear_) {
    is_taken_[i] = 0;
    (is_clear_before(model, pairs_[i]) ? deferred : close).push_back(i);
  }
  keep_checked(model, lanes, close);
}

void WatchedPairs::keep_checked(const WorldModel& model, FrameLanes& lanes,
                                std::vector<std::uint32_t>& indices) {
  constexpr std::size_t kPairsAtOnce = 64;
  gathered_.resize(std::max(gathered_.size(), indices.size()));
  std::atomic<std::size_t> count{0};
  lanes.for_each(indices.size(), kPairsAtOnce, [&](NarrowphaseQuery&, std::size_t i) {
    const SolidPair pair = pairs_.solids(indices[i]);
    if (model.is_checked(pair)) gathered_[count.fetch_add(1, std::memory_order_relaxed)] = {pair, indices[i]};
  });
  std::sort(gathered_.begin(), gathered_.begin() + static_cast<std::ptrdiff_t>(count));
  indices.clear();
  for (const GatheredPair& pair : std::span(gathered_).first(count)) indices.push_back(pair.watch);
}

}  // namespace touchstone
