#include "touchstone/contact_core/world/frame/watched_pairs.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <utility>

#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/memory/reserve_more.hpp"
#include "touchstone/contact_core/world/frame/level_search.hpp"

namespace touchstone {
namespace {

/// Solids may go this many times as far as on the path at hand, and this share of their radius, before the
/// broadphase is asked again.
constexpr double kReserveFrames = 8.0;
constexpr double kReserveRadius = 0.125;
/// The same factor for what slides ask.
constexpr double kReserveNeeds = 1.5;
/// Of more objects than one in this many the pairs are found together with all others.
constexpr std::size_t kWatchAll = 4;
/// What has not moved for so many frames rests: an arm's pairs with it are looked at together.
constexpr std::uint64_t kRestFrames = 8;
/// All objects look this share further than a warn distance that was raised, so that the next ones like it
/// cost no search.
constexpr double kBeyondWarn = 0.125;
/// Rounding of bounds.
constexpr double kUp = 1.0 + 0x1p-20;

/// By slots.
bool may_meet(const WorldModel& model, std::uint32_t a, std::uint32_t b) {
  const ObjectTable& objects = model.objects;
  if (!model.layout.is_alive(a) || !model.layout.is_alive(b)) return false;
  return objects[a].body != objects[b].body && !(objects[a].is_static() && objects[b].is_static());
}

bool may_be_watched(const WorldModel& model, const SolidPair& pair) {
  const Layout& layout = model.layout;
  return may_meet(model, layout.slot_of[pair.a], layout.slot_of[pair.b]) && !layout.is_exempt(pair);
}

/// Whether Travels' plan has what the path at hand takes the slot's solids.
bool is_planned(const WorldModel& model, std::uint32_t slot) {
  const MechanismMover* mover = model.mechanism_of(slot);
  return mover != nullptr && model.has_planned(*mover);
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
  const std::size_t proxies = model.layout.slot_of_proxy.size();
  size(is_noted_due_, slots), size(is_noted_idle_, slots), size(is_looked_at_, slots), size(reaches_, slots),
      size(regions_, proxies);
  size(goes_, solids), size(last_frame_, slots);
  if (anew) going_.clear();
  reserve_more(going_, slots);
  resize_more(stands_, proxies), resize_more(objects_stand_, slots);
  reserve_more(due_, slots), reserve_more(idle_, slots), reserve_more(moved_, slots),
      reserve_more(movable_, slots);
  reserve_more(looked_at_, slots);
  room_ = std::max<std::size_t>(256 + 64 * solids, pairs_.size());
  for (PairWatch* pairs : {&pairs_, &pairs_before_}) {
    pairs->reserve(room_), pairs->set_solids(solids);
    pairs->set_link_pairs(model.travels.of_link_pair.size());
  }
  for (GrowingList<std::uint32_t>* indices : {&unclear_, &taken_}) reserve_more(*indices, room_);
  reserve_more(gathered_, room_), reserve_more(is_taken_, room_), reserve_more(found_, room_);
  reserve_more(partners_, solids), resize_more(marks_, solids), reserve_more(proxies_, proxies);
}

bool WatchedPairs::begin(const WorldModel& model, Broadphase& broadphase, double within) {
  half_beyond_ = 0.5 * std::max(within - model.margin, 0.0);
  reaches_.assign(model.layout.slots(), 0.0);
  model.rules.find_reaches(model.objects, reaches_);
  early_reaches_.clear();
  moved_.clear(), due_.clear(), unclear_.clear();
  pairs_.clear();
  pairs_.set_solids(model.layout.solids.size());
  needs_watch_ = true;
  movable_.clear();
  for (std::uint32_t slot = 0; slot < model.layout.slots(); ++slot) {
    place(model, slot);
    if (model.layout.is_alive(slot)) movable_.push_back(slot);
  }
  return broadphase.update_paths({stands_, stands_, regions_}, movable_);
}

void WatchedPairs::begin_object(const WorldModel& model, std::uint32_t slot) {
  reaches_[slot] = model.layout.is_alive(slot) ? model.rules.reach_of(model.objects, slot) : 0.0;
  for (SolidIndex i = model.layout.first_solid[slot]; i < model.layout.first_solid[slot + 1]; ++i)
    goes_[i] = 0;
  place(model, slot);
  if (model.layout.is_alive(slot)) watch_anew(model, slot);
}

/// The slot's object stands where the model has it, at rest.
void WatchedPairs::place(const WorldModel& model, std::uint32_t slot) {
  const Layout& layout = model.layout;
  if (layout.levels[slot] != nullptr) {
    place_object(model, slot);
    regions_[layout.first_proxy[slot]] = beyond_margin(slot) + model.contact_reach_of_object(slot, 0.0);
    return;
  }
  for (SolidIndex i = layout.first_solid[slot]; i < layout.first_solid[slot + 1]; ++i) {
    const SolidIndex proxy = layout.proxy_of(slot, i);
    stands_[proxy] = model.from[i];
    regions_[proxy] = beyond_margin(slot) + model.contact_reach(i, 0.0);
  }
}

/// As one with levels stands.
void WatchedPairs::place_object(const WorldModel& model, std::uint32_t slot) {
  objects_stand_[slot] = model.objects[slot].X_WO;
  const PlacedHexahedron& box = model.layout.levels[slot]->box().solids().front();
  stands_[model.layout.first_proxy[slot]] = compose(objects_stand_[slot], box.X_OS);
}

void WatchedPairs::forget(const WorldModel& model, std::uint32_t slot) {
  for (SolidIndex i = model.layout.first_solid[slot]; i < model.layout.first_solid[slot + 1]; ++i)
    pairs_.for_each_of(i, [&](std::uint32_t index) { pairs_.remove(index); });
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

void WatchedPairs::look_further(const WorldModel& model, double by, double within) {
  // What is watched already may matter sooner.
  reserve_more(unclear_, pairs_.size());
  pairs_.shorten_clearances(by);
  unclear_.clear();
  for (std::uint32_t index = 0; index < pairs_.size(); ++index)
    if (pairs_.is_used(index) && !model.is_clear(pairs_[index])) unclear_.push_back(index);
  // Others are found with the next frame.
  if (within <= model.margin + 2.0 * half_beyond_) return;
  half_beyond_ = 0.5 * ((1.0 + kBeyondWarn) * within - model.margin);
  needs_watch_ = is_beyond_new_ = true;
}

void WatchedPairs::take_up_early_reaches(const ObjectTable& objects) {
  for (const auto& [object, warn] : early_reaches_)
    if (objects.is_alive(object)) reaches_[object.slot] = std::max(reaches_[object.slot], warn);
  early_reaches_.clear();
}

void WatchedPairs::begin_frame(WorldModel& model) {
  ++frame_;
  note_those_at_rest(model);
  if (!is_overflown_) return;
  is_overflown_ = false;
  std::fill(model.travels.of_solid.begin(), model.travels.of_solid.end(), 0.0);
  std::fill(model.travels.of_object.begin(), model.travels.of_object.end(), 0.0);
  std::fill(model.travels.of_link_pair.begin(), model.travels.of_link_pair.end(), 0.0);
  pairs_.clear();
  needs_watch_ = true;
}

/// Those that an arm carries are of the arm: they wait until they are let go.
void WatchedPairs::note_those_at_rest(const WorldModel& model) {
  erase_if(going_, [&](std::uint32_t slot) {
    if (frame_ - last_frame_[slot] <= kRestFrames || model.mechanism_of(slot) != nullptr) return false;
    last_frame_[slot] = 0;
    for (SolidIndex i = model.layout.first_solid[slot]; i < model.layout.first_solid[slot + 1]; ++i)
      if (std::exchange(goes_[i], std::uint8_t{0}) != 0) pairs_.note_rests(i, model.travels.of_solid[i]);
    return true;
  });
}

void WatchedPairs::lay_paths(WorldModel& model, std::span<const std::uint32_t> roots) {
  for (const std::uint32_t slot : moved_) {
    model.travels.last_object[slot] = 0.0;
    model.for_each_solid_of(slot, [&](SolidIndex solid) { model.travels.last_solid[solid] = 0.0; });
  }
  moved_.clear();
  std::fill(model.travels.last_link_pair.begin(), model.travels.last_link_pair.end(), 0.0);
  for (const std::uint32_t root : roots)
    if (model.in_motion[root]) lay_travels(model, root);
  std::sort(moved_.begin(), moved_.end());
}

void WatchedPairs::lay_travels(WorldModel& model, std::uint32_t root) {
  model.for_each_member(root, [&](std::uint32_t slot) {
    if (!model.moves(slot)) return;
    moved_.push_back(slot);
    const MechanismMover* mover = model.arm_of(slot);
    const BodyState start = mover == nullptr ? model.state_at(slot, 0.0) : BodyState{};
    if (model.layout.levels[slot] != nullptr) lay_object_travel(model, slot, start);
    if (mover == nullptr) {
      model.for_each_solid_of(slot, [&](SolidIndex solid) { lay_travel(model, solid, start); });
      return;
    }
    Travels& travels = model.travels;
    if (is_planned(model, slot))
      model.for_each_solid_of(
          slot, [&](SolidIndex solid) { travels.last_solid[solid] = travels.planned_solid[solid]; });
    else
      model.measure_travels(*mover, slot, travels.last_solid);
    model.for_each_solid_of(slot, [&](SolidIndex solid) { add_travel(model, solid); });
  });
  if (const MechanismMover* mover = model.mechanism_of(root)) lay_link_travels(model, *mover);
}

/// Of one with levels: no point of it goes further.
void WatchedPairs::lay_object_travel(WorldModel& model, std::uint32_t slot, const BodyState& start) {
  Travels& travels = model.travels;
  const Sphere& sphere_O = model.layout.levels[slot]->sphere_O();
  if (const MechanismMover* mover = model.arm_of(slot)) {
    const Pose& X_BO = model.objects.poses_in_body()[slot];
    travels.last_object[slot] =
        model.travel_on(*mover, slot, {transform(X_BO, sphere_O.centre), sphere_O.radius});
  } else {
    const Vector3 centre_W = transform(model.objects[slot].X_WO, sphere_O.centre);
    const double arm = norm(centre_W - start.centre_W) + sphere_O.radius;
    travels.last_object[slot] = (norm(start.velocity_W) + norm(start.angular_velocity_W) * arm) * kUp;
  }
  travels.of_object[slot] = Travels::sum(travels.of_object[slot], travels.last_object[slot]);
  if (!(travels.of_object[slot] <= travels.object_limit[slot])) note_due(slot);
  is_overflown_ = is_overflown_ || !(travels.of_object[slot] <= Travels::kMost);
}

void WatchedPairs::lay_travel(WorldModel& model, SolidIndex solid, const BodyState& start) {
  Travels& travels = model.travels;
  const Sphere& sphere = model.layout.solids[solid].bounding_sphere();
  const std::uint32_t slot = model.layout.slot_of[solid];
  if (const MechanismMover* mover = model.arm_of(slot)) {
    travels.last_solid[solid] =
        is_planned(model, slot) ? travels.planned_solid[solid] : model.travel_on(*mover, solid);
  } else {
    const double arm = norm(transform(model.from[solid], sphere.centre) - start.centre_W) + sphere.radius;
    travels.last_solid[solid] = (norm(start.velocity_W) + norm(start.angular_velocity_W) * arm) * kUp;
  }
  add_travel(model, solid);
}

void WatchedPairs::note_goes(std::uint32_t slot, SolidIndex solid) {
  if (std::exchange(goes_[solid], std::uint8_t{1}) == 0) pairs_.note_moves(solid);
  if (std::exchange(last_frame_[slot], frame_) == 0) going_.push_back(slot);
}

/// That of the path at hand, to the sums of all paths.
void WatchedPairs::add_travel(WorldModel& model, SolidIndex solid) {
  Travels& travels = model.travels;
  const std::uint32_t slot = model.layout.slot_of[solid];
  if (model.mechanism_of(slot) == nullptr) note_goes(slot, solid);
  travels.of_solid[solid] = Travels::sum(travels.of_solid[solid], travels.last_solid[solid]);
  if (!(travels.of_solid[solid] <= travels.solid_limit[solid]) && model.layout.levels[slot] == nullptr)
    note_due(slot);
  is_overflown_ = is_overflown_ || !(travels.of_solid[solid] <= Travels::kMost);
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
  model.for_each_member(root, [&](std::uint32_t slot) {
    shorten(travels.of_object[slot], travels.last_object[slot]);
    model.for_each_solid_of(
        slot, [&](SolidIndex solid) { shorten(travels.of_solid[solid], travels.last_solid[solid]); });
  });
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
  erase_if(due_, [&](std::uint32_t slot) {
    if (model.layout.is_alive(slot)) return false;
    is_noted_due_[slot] = 0;
    return true;
  });
  const bool all = needs_watch_ || kWatchAll * due_.size() > model.layout.slots();
  if (all || !update_due(model, broadphase)) update_all(model, broadphase);
  for (const std::uint32_t slot : due_) is_noted_due_[slot] = 0;
  due_.clear();
  needs_watch_ = false;
}

/// Where the object's solids may be until its pairs are found anew.
void WatchedPairs::set_region(WorldModel& model, std::uint32_t slot) {
  Travels& travels = model.travels;
  const Layout& layout = model.layout;
  const bool is_static = layout.is_static[slot] != 0;
  if (layout.levels[slot] != nullptr) {
    set_region_of_object(model, slot);
    return;
  }
  for (SolidIndex solid = layout.first_solid[slot]; solid < layout.first_solid[slot + 1]; ++solid) {
    const SolidIndex proxy = layout.proxy_of(slot, solid);
    const double radius = layout.solids[solid].bounding_sphere().radius;
    const double usual = kReserveFrames * travels.last_solid[solid] + kReserveRadius * radius;
    const double reserve = is_static ? 0.0 : std::max(usual, kReserveNeeds * travels.needed[solid]);
    stands_[proxy] = model.from[solid];
    regions_[proxy] = (reserve + beyond_margin(slot) + model.contact_reach(solid, reserve)) * kUp;
    // The path at hand is counted already, but not gone yet.
    travels.solid_limit[solid] = travels.of_solid[solid] - travels.last_solid[solid] * kUp + reserve;
  }
}

/// All of an object with levels has the same reserve.
void WatchedPairs::set_region_of_object(WorldModel& model, std::uint32_t slot) {
  Travels& travels = model.travels;
  const double usual =
      kReserveFrames * travels.last_object[slot] + kReserveRadius * model.layout.levels[slot]->mean_radius();
  const double reserve = std::max(usual, kReserveNeeds * travels.needed_object[slot]);
  place_object(model, slot);
  regions_[model.layout.first_proxy[slot]] =
      (reserve + beyond_margin(slot) + model.contact_reach_of_object(slot, reserve)) * kUp;
  travels.object_limit[slot] = travels.of_object[slot] - travels.last_object[slot] * kUp + reserve;
}

/// @returns false where the broadphase knows all pairs only.
bool WatchedPairs::update_due(WorldModel& model, Broadphase& broadphase) {
  const Layout& layout = model.layout;
  std::sort(due_.begin(), due_.end());
  for (const std::uint32_t slot : due_) set_region(model, slot);
  broadphase.update_paths({stands_, stands_, regions_}, due_);
  for (const std::uint32_t slot : due_) {
    if (layout.levels[slot] != nullptr) {
      if (!update_object_partners(model, broadphase, slot)) return false;
      continue;
    }
    for (SolidIndex solid = layout.first_solid[slot]; solid < layout.first_solid[slot + 1]; ++solid) {
      if (!find_partners(model, broadphase, slot, layout.proxy_of(slot, solid))) return false;
      update_partners(model, solid);
    }
  }
  return true;
}

/// Solids that may come near those of the proxy: partners_, of one solid; found_ has them with the solids of
/// objects with levels.
bool WatchedPairs::find_partners(const WorldModel& model, Broadphase& broadphase, std::uint32_t slot,
                                 SolidIndex proxy) {
  const Layout& layout = model.layout;
  proxies_.clear(), partners_.clear(), found_.clear();
  if (!broadphase.find_partners(proxy, proxies_)) return false;
  for (const SolidIndex other : proxies_) {
    const std::uint32_t other_slot = layout.slot_of_proxy[other];
    if (layout.levels[slot] != nullptr || layout.levels[other_slot] != nullptr)
      search_levels(model, proxy, other);
    else
      partners_.push_back(layout.solid_of(other_slot, other));
  }
  if (layout.levels[slot] != nullptr) return true;
  const SolidIndex solid = layout.solid_of(slot, proxy);
  for (const SolidPair& pair : found_) partners_.push_back(pair.a == solid ? pair.b : pair.a);
  return true;
}

/// Appends to found_ the pairs of two proxies, one of which at least is an object with levels.
void WatchedPairs::search_levels(const WorldModel& model, SolidIndex a, SolidIndex b) {
  const Layout& layout = model.layout;
  if (!may_meet(model, layout.slot_of_proxy[a], layout.slot_of_proxy[b])) return;
  const auto body_of = [&](SolidIndex proxy) -> SearchedBody {
    const std::uint32_t slot = layout.slot_of_proxy[proxy];
    const SolidIndex first = layout.first_solid[slot];
    if (const ObjectLevels* levels = layout.levels[slot])
      return {levels, &layout.solids[first], &layout.X_OS[first], first, objects_stand_[slot]};
    const SolidIndex solid = layout.solid_of(slot, proxy);
    return {nullptr, &layout.solids[solid], nullptr, solid, stands_[proxy]};
  };
  find_pairs_within((regions_[a] + regions_[b] + model.margin) * kUp, body_of(a), body_of(b), found_);
}

/// Of an object with levels: solids that may come near others are open from now on, and no others are.
bool WatchedPairs::update_object_partners(WorldModel& model, Broadphase& broadphase, std::uint32_t slot) {
  const Layout& layout = model.layout;
  const SolidIndex first = layout.first_solid[slot], end = layout.first_solid[slot + 1];
  if (!find_partners(model, broadphase, slot, layout.first_proxy[slot])) return false;
  // The object's own solid comes first in each pair.
  for (SolidPair& pair : found_)
    if (pair.a < first || pair.a >= end) std::swap(pair.a, pair.b);
  std::sort(found_.begin(), found_.end());
  for (const SolidPair& pair : found_) open(model, pair.a);
  // Pairs of each open solid are brought up to date.
  auto next = found_.begin();
  model.for_each_solid_of(slot, [&](SolidIndex solid) {
    partners_.clear();
    for (; next != found_.end() && next->a == solid; ++next) partners_.push_back(next->b);
    update_partners(model, solid);
  });
  note_idle(slot);
  return true;
}

/// From now on the solid is looked at by itself.
void WatchedPairs::open(WorldModel& model, SolidIndex solid) {
  const Layout& layout = model.layout;
  const std::uint32_t slot = layout.slot_of[solid];
  if (layout.levels[slot] == nullptr || model.open.is_open(solid)) return;
  model.open.open(slot, layout.first_solid[slot], solid);
  // It stands and goes as its object does.
  Travels& travels = model.travels;
  model.from[solid] = compose(model.objects[slot].X_WO, layout.X_OS[solid]);
  travels.has_vertices[solid] = 0;
  const MechanismMover* mover = model.mechanism_of(slot);
  const bool is_planned = mover != nullptr && model.has_planned(*mover) && model.moves(slot);
  travels.planned_solid[solid] = is_planned ? model.travel_on(*mover, solid) : 0.0;
  travels.last_solid[solid] = 0.0;
  if (model.in_motion[model.objects[slot].root] && std::binary_search(moved_.begin(), moved_.end(), slot))
    lay_travel(model, solid, model.state_at(slot, 0.0));
}

/// Some of the slot's solids may be watched with nothing any more.
void WatchedPairs::note_idle(std::uint32_t slot) {
  if (is_noted_idle_[slot] != 0) return;
  is_noted_idle_[slot] = 1;
  idle_.push_back(slot);
}

void WatchedPairs::end_frame(WorldModel& model) {
  for (const std::uint32_t slot : idle_) {
    is_noted_idle_[slot] = 0;
    close_idle(model, slot);
  }
  idle_.clear();
}

/// Those of an object with levels that are watched with nothing.
void WatchedPairs::close_idle(WorldModel& model, std::uint32_t slot) {
  model.open.close_idle(slot, model.layout.first_solid[slot], [&](SolidIndex solid) {
    if (pairs_.has_any_of(solid)) return false;
    model.travels.last_solid[solid] = model.travels.planned_solid[solid] = 0.0;
    return true;
  });
}

/// Watches the solid with partners_; keeps the data of pairs that are watched already.
void WatchedPairs::update_partners(WorldModel& model, SolidIndex solid) {
  // Marks of this call: a partner was found; and is watched already.
  const std::uint64_t found = last_mark_ + 1, known = last_mark_ += 2;
  for (const SolidIndex other : partners_) marks_[other] = found;
  pairs_.for_each_of(solid, [&](std::uint32_t index) {
    const SolidPair pair = pairs_.solids(index);
    std::uint64_t& mark = marks_[pair.a == solid ? pair.b : pair.a];
    if (mark == found)
      mark = known;
    else
      pairs_.remove(index);
  });
  // The others are new.
  std::erase_if(partners_, [&](SolidIndex other) {
    const SolidPair pair{std::min(solid, other), std::max(solid, other)};
    return marks_[other] == known || !may_be_watched(model, pair);
  });
  std::sort(partners_.begin(), partners_.end());
  for (const SolidIndex other : partners_) {
    const SolidPair pair{std::min(solid, other), std::max(solid, other)};
    open(model, other);
    add(model, {pair.a, pair.b, model.link_pair_index(pair), kNotKnown});
  }
}

void WatchedPairs::add(const WorldModel& model, const WatchedPair& pair) {
  const auto is_of_arm = [&](SolidIndex solid) {
    return model.mechanisms.size() > 0 && model.mechanism_of(model.layout.slot_of[solid]) != nullptr;
  };
  if (!is_of_arm(pair.a) && !is_of_arm(pair.b)) {
    unclear_.push_back(pairs_.add(pair));
    return;
  }
  // Until note_goes() says otherwise.
  const auto stands = [&](SolidIndex solid) { return !is_of_arm(solid) && goes_[solid] == 0; };
  const SolidIndex standing = stands(pair.b) ? pair.b : stands(pair.a) ? pair.a : kNoIndex;
  const SolidIndex moving = standing == kNoIndex ? kNoIndex : standing == pair.b ? pair.a : pair.b;
  const double gone = standing == kNoIndex ? 0.0 : model.travels.of_solid[standing];
  unclear_.push_back(pairs_.add_of_arm(pair, moving, gone));
}

void WatchedPairs::update_all(WorldModel& model, Broadphase& broadphase) {
  const Layout& layout = model.layout;
  // Objects that may move get the region that they can reach before the next update.
  movable_.clear();
  for (std::uint32_t slot = 0; slot < layout.slots(); ++slot) {
    if (!layout.is_alive(slot)) continue;
    const bool stays = layout.is_static[slot] != 0 && is_noted_due_[slot] == 0 && reaches_[slot] == 0.0;
    if (stays && !is_beyond_new_) continue;
    set_region(model, slot);
    movable_.push_back(slot);
  }
  is_beyond_new_ = false;
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
    for (const SolidPair& proxies : std::span(block).first(count)) {
      const std::uint32_t a = layout.slot_of_proxy[proxies.a], b = layout.slot_of_proxy[proxies.b];
      if (layout.levels[a] == nullptr && layout.levels[b] == nullptr) {
        watch_again(model, {layout.solid_of(a, proxies.a), layout.solid_of(b, proxies.b)});
        continue;
      }
      found_.clear();
      search_levels(model, proxies.a, proxies.b);
      for (const SolidPair& pair : found_) watch_again(model, pair);
    }
  }
  for (std::uint32_t slot = 0; slot < layout.slots(); ++slot)
    if (layout.levels[slot] != nullptr) note_idle(slot);
}

/// A pair that was watched before keeps what is known of it.
void WatchedPairs::watch_again(WorldModel& model, const SolidPair& pair) {
  if (!may_be_watched(model, pair)) return;
  WatchedPair watch{pair.a, pair.b, model.link_pair_index(pair), kNotKnown};
  const std::uint32_t before = pairs_before_.find(pair);
  if (before != kNoIndex)
    watch.clear_until = pairs_before_[before].clear_until, watch.axis_W = pairs_before_[before].axis_W;
  open(model, pair.a), open(model, pair.b);
  add(model, watch);
}

/// Roots that move or have moved since, but for arms, whose many pairs are looked at in groups.
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
                          GrowingList<std::uint32_t>& close, GrowingList<std::uint32_t>& deferred) {
  constexpr std::size_t kRootsAtOnce = 16;
  find_looked_at(model, movers);
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
  // Pairs that were not clear before, and those of arms, are added once.
  const auto take_once = [&](std::uint32_t i) {
    if (is_taken_[i] || model.is_clear(pairs_[i])) return;
    if (is_looked_at_[model.root_of(pairs_[i].a)] || is_looked_at_[model.root_of(pairs_[i].b)]) return;
    is_taken_[i] = 1;
    take(i);
  };
  std::for_each(unclear_.begin(), unclear_.end(), take_once);
  pairs_.for_each_of_arms_beyond(
      [&](const WatchedPair& watch) {
        return model.travelled({watch.a, watch.b}, watch.link_pair);
      },
      take_once);
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
                                GrowingList<std::uint32_t>& indices) {
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
