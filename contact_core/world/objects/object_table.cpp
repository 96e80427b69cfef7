#include "touchstone/contact_core/world/objects/object_table.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <functional>
#include <iterator>
#include <new>
#include <utility>

#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/memory/reserve_more.hpp"

namespace touchstone {
namespace {

constexpr std::uint32_t kMostGroups = 64;

std::uint32_t solid_index(const HexahedronTree& tree, std::string_view name) {
  if (name.empty()) return kAllSolids;
  for (std::uint32_t i = 0; i < tree.solids().size(); ++i)
    if (tree.solids()[i].name == name) return i;
  throw InputError("object '" + tree.name() + "' has no hexahedron '" + std::string(name) + "'");
}

// Lists of changes that a slot is in.
constexpr std::uint8_t kReplaced = 1, kRebodied = 2, kMoved = 4;

/// For `count` in all, and for as many again where a list grows.
template <class T>
void make_room(std::vector<T>& list, std::size_t count) {
  if (count > list.capacity()) list.reserve(2 * count);
}

/// Objects that are alike in this may take each other's slots.
std::pair<std::size_t, bool> places_of(const ObjectRecord& object) {
  return {object.description.tree->solids().size(), object.levels != nullptr};
}

std::shared_ptr<const ObjectLevels> levels_of(const ObjectDescription& object) {
  const bool has_levels = !object.levels.empty();
  const bool is_large = object.tree->solids().size() >= kSearchedFrom || has_levels;
  const bool has_bounds = is_large && !object.is_static && object.is_searched;
  if (!has_bounds && !has_levels) return nullptr;
  // Levels that do nothing are refused as others are.
  auto levels = std::make_shared<const ObjectLevels>(*object.tree, object.levels);
  return has_bounds ? std::move(levels) : nullptr;
}

}  // namespace

/// One whose places for solids fit this object; else the next one.
std::uint32_t ObjectTable::slot_for(const ObjectRecord& object) const {
  const auto fitting = free_slots_.find(places_of(object));
  return fitting == free_slots_.end() || fitting->second.slots.empty() ? size()
                                                                       : fitting->second.slots.front();
}

/// In all lists, for an object that is to be put there: put() then needs no more memory, nor does what
/// becomes of the object later.
void ObjectTable::make_room_for(const ObjectRecord& object, std::uint32_t slot) {
  for (std::uint64_t left = object.groups; left != 0; left &= left - 1)
    make_room_in_group(static_cast<std::uint32_t>(std::countr_zero(left)));
  if (slot < size()) return;
  const std::size_t slots = std::size_t{slot} + 1;
  // Each list of changes names a slot once at most, and so does the one of free slots that are alike.
  for (std::vector<std::uint32_t>* changed : {&changes_.replaced, &changes_.moved, &changes_.rebodied})
    make_room(*changed, slots);
  FreeSlots& alike = free_slots_[places_of(object)];
  make_room(alike.slots, alike.count + 1);
  resize_more(X_BO_, slots), resize_more(X_CO_, slots), resize_more(is_noted_, slots);
  records_.make_room();
}

/// @pre make_room_for().
ObjectHandle ObjectTable::put(ObjectRecord&& object, std::uint32_t slot) noexcept {
  FreeSlots& alike = free_slots_.find(places_of(object))->second;
  if (slot == size()) {
    records_.emplace_back();
    ++alike.count;
  } else {
    std::pop_heap(alike.slots.begin(), alike.slots.end(), std::greater<>());
    alike.slots.pop_back();
  }
  ObjectRecord& record = records_[slot];
  const std::uint32_t generation = record.generation + 1;
  record = std::move(object);
  record.generation = generation;
  record.body = record.root = slot;
  X_BO_[slot] = X_CO_[slot] = {};
  for (std::uint64_t left = record.groups; left != 0; left &= left - 1)
    group_members_[std::countr_zero(left)].push_back(handle(slot));
  note(changes_.replaced, slot, kReplaced);
  return {slot, generation};
}

ObjectHandle ObjectTable::add(ObjectDescription description) {
  if (!description.tree) throw InputError("contact world: an object without hexahedra");
  const std::string& name = description.tree->name();
  validate_pose(description.X_WO, "object '" + name + "'");
  if (slot_of_name_.contains(name)) throw InputError("object '" + name + "': the name is taken");
  ObjectRecord added;
  added.levels = levels_of(description);
  added.alive = true;
  added.X_WO = added.commanded = description.X_WO;
  added.carrier = kNoIndex;
  // Where memory ends, new groups go again; once the name is taken up nothing needs more.
  const std::size_t known_groups = group_names_.size();
  try {
    for (const std::uint32_t group : groups(description.groups)) added.groups |= std::uint64_t{1} << group;
    added.description = std::move(description);
    const std::uint32_t slot = slot_for(added);
    make_room_for(added, slot);
    slot_of_name_.emplace(added.name(), slot);
    return put(std::move(added), slot);
  } catch (...) {
    forget_groups_from(known_groups);
    throw;
  }
}

/// In room that make_room_for() made.
void ObjectTable::note(std::vector<std::uint32_t>& slots, std::uint32_t slot, std::uint8_t flag) noexcept {
  if ((is_noted_[slot] & flag) != 0) return;
  slots.push_back(slot);
  is_noted_[slot] |= flag;
}

/// Where memory ends, all is to be taken up anew instead.
void ObjectTable::note(const SolidExemption& exemption, bool is_on) noexcept {
  if (changes_.all) return;
  try {
    changes_.all = changes_.exemptions.size() >= TableChanges::kMostExemptions;
    if (!changes_.all) changes_.exemptions.push_back({exemption, is_on});
  } catch (const std::bad_alloc&) {
    changes_.all = true;
  }
  if (changes_.all) changes_.exemptions.clear();
}

void ObjectTable::forget_changes() {
  for (std::vector<std::uint32_t>* slots : {&changes_.replaced, &changes_.moved, &changes_.rebodied}) {
    for (const std::uint32_t slot : *slots) is_noted_[slot] = 0;
    slots->clear();
  }
  changes_.exemptions.clear();
  changes_.all = false;
}

/// For one more member: where its list is full, those that are gone leave it first.
void ObjectTable::make_room_in_group(std::uint32_t group) {
  std::vector<ObjectHandle>& members = group_members_[group];
  if (members.size() < members.capacity()) return;
  std::erase_if(members, [&](const ObjectHandle& member) { return !is_alive(member); });
  if (2 * members.size() >= members.capacity()) members.reserve(2 * members.capacity() + 16);
}

void ObjectTable::check_removable(ObjectHandle object) const {
  const std::uint32_t slot = slot_of(object);
  const ObjectRecord& record = records_[slot];
  if (record.carrier != kNoIndex)
    throw InputError("object '" + record.name() + "' is latched to '" + records_[record.carrier].name() +
                     "': unlatch it before it is removed");
  if (record.first_carried != kNoIndex)
    throw InputError("object '" + record.name() + "' carries '" + records_[record.first_carried].name() +
                     "': unlatch it before it is removed");
}

void ObjectTable::remove(ObjectHandle object) {
  const ObjectRecord& record = records_[slot_of(object)];
  if (record.is_link())
    throw InputError("object '" + record.name() + "' is a link: its mechanism is removed as a whole");
  check_removable(object);
  remove_link(object);
}

void ObjectTable::remove_link(ObjectHandle object) noexcept {
  ObjectRecord& record = records_[object.slot];
  while (!record.exemptions.empty()) drop_exemption(SolidExemption(record.exemptions.back()));
  record.alive = false;
  slot_of_name_.erase(record.name());
  std::vector<std::uint32_t>& free = free_slots_.find(places_of(record))->second.slots;
  free.push_back(object.slot);
  std::push_heap(free.begin(), free.end(), std::greater<>());
  note(changes_.replaced, object.slot, kReplaced);
}

void ObjectTable::make_link(ObjectHandle object, std::uint32_t mechanism, std::uint32_t link,
                            std::uint32_t lead) {
  ObjectRecord& record = records_[slot_of(object)];
  record.mechanism = mechanism;
  record.link = link;
  record.lead = lead;
  find_bodies(object.slot);
}

bool ObjectTable::add_exemption(const SolidExemption& exemption) {
  const auto make_place = [](std::vector<SolidExemption>& list) { make_room(list, list.size() + 1); };
  for (const ObjectHandle& object : {exemption.a, exemption.b}) make_place(records_[object.slot].exemptions);
  const bool ends_with_latch = exemption.carried != ObjectHandle{};
  if (ends_with_latch) make_place(records_[exemption.carried.slot].allowed);
  if (!exemptions_.insert(exemption).second) return false;
  for (const ObjectHandle& object : {exemption.a, exemption.b})
    records_[object.slot].exemptions.push_back(exemption);
  if (ends_with_latch) records_[exemption.carried.slot].allowed.push_back(exemption);
  note(exemption, true);
  return true;
}

void ObjectTable::drop_exemption(const SolidExemption& exemption) noexcept {
  if (exemptions_.erase(exemption) == 0) return;
  for (const ObjectHandle& object : {exemption.a, exemption.b})
    std::erase(records_[object.slot].exemptions, exemption);
  if (exemption.carried != ObjectHandle{}) std::erase(records_[exemption.carried.slot].allowed, exemption);
  note(exemption, false);
}

SolidExemption ObjectTable::find(const Exemption& pair, ObjectHandle carried) const {
  const HexahedronTree& tree_a = *records_[slot_of(pair.a)].description.tree;
  const HexahedronTree& tree_b = *records_[slot_of(pair.b)].description.tree;
  if (pair.a == pair.b)
    throw InputError("object '" + tree_a.name() + "': hexahedra of one object are never checked");
  SolidExemption out{pair.a, pair.b, solid_index(tree_a, pair.solid_a), solid_index(tree_b, pair.solid_b),
                     carried};
  if (out.b < out.a) std::swap(out.a, out.b), std::swap(out.solid_a, out.solid_b);
  return out;
}

void ObjectTable::exempt(const Exemption& pair) { add_exemption(find(pair, {})); }

void ObjectTable::unexempt(const Exemption& pair) {
  const SolidExemption found = find(pair, {});
  if (!exemptions_.contains(found))
    throw InputError("objects '" + records_[pair.a.slot].name() + "' and '" + records_[pair.b.slot].name() +
                     "' are not exempt by these names");
  drop_exemption(found);
}

void ObjectTable::check_latch(std::uint32_t carrier, std::uint32_t carried) const {
  const ObjectRecord& record = records_[carried];
  if (record.carrier != kNoIndex)
    throw InputError("object '" + record.name() + "' is already latched to '" +
                     records_[record.carrier].name() + "'");
  if (record.is_static()) throw InputError("object '" + record.name() + "' is static and cannot be carried");
  if (record.is_link())
    throw InputError("object '" + record.name() + "' is a link of a mechanism and cannot be carried");
  for (std::uint32_t i = carrier; i != kNoIndex; i = records_[i].carrier)
    if (i == carried)
      throw InputError("latching '" + record.name() + "' to '" + records_[carrier].name() +
                       "' would close a cycle");
}

void ObjectTable::latch(ObjectHandle carrier, ObjectHandle carried, std::span<const Exemption> allowed) {
  const std::uint32_t to = slot_of(carrier), slot = slot_of(carried);
  check_latch(to, slot);
  std::vector<SolidExemption> found;
  for (const Exemption& pair : allowed) found.push_back(find(pair, carried));
  try {
    for (const SolidExemption& exemption : found) add_exemption(exemption);
  } catch (...) {
    for (const SolidExemption& exemption : found) drop_exemption(exemption);
    throw;
  }
  records_[slot].carrier = to;
  records_[slot].next_carried = std::exchange(records_[to].first_carried, slot);
  X_CO_[slot] = compose(inverse(records_[to].X_WO), records_[slot].X_WO);
  find_bodies(slot);
}

void ObjectTable::unlink(std::uint32_t carried) noexcept {
  ObjectRecord& record = records_[carried];
  std::uint32_t* place = &records_[record.carrier].first_carried;
  while (*place != carried) place = &records_[*place].next_carried;
  *place = record.next_carried;
  record.carrier = record.next_carried = kNoIndex;
  while (!record.allowed.empty()) drop_exemption(SolidExemption(record.allowed.back()));
}

void ObjectTable::unlatch(ObjectHandle carried) {
  const ObjectRecord& record = records_[slot_of(carried)];
  if (record.carrier == kNoIndex) throw InputError("object '" + record.name() + "' is not latched");
  unlink(carried.slot);
  find_bodies(carried.slot);
}

/// Of an object and all that it carries, whose carrier's is known.
void ObjectTable::find_bodies(std::uint32_t slot) noexcept {
  for (std::uint32_t next = slot; next != kNoIndex; next = after_in_chain(next, slot)) {
    std::uint32_t body = next;
    Pose X_BO;
    while (records_[body].carrier != kNoIndex) {
      X_BO = compose(X_CO_[body], X_BO);
      body = records_[body].carrier;
    }
    records_[next].body = body;
    records_[next].root = records_[body].is_link() ? records_[body].lead : body;
    X_BO_[next] = X_BO;
    note(changes_.rebodied, next, kRebodied);
  }
}

/// What comes after a slot among all that `first` carries, each after its carrier. @returns kNoIndex: none.
std::uint32_t ObjectTable::after_in_chain(std::uint32_t slot, std::uint32_t first) const noexcept {
  if (records_[slot].first_carried != kNoIndex) return records_[slot].first_carried;
  while (slot != first && records_[slot].next_carried == kNoIndex) slot = records_[slot].carrier;
  return slot == first ? kNoIndex : records_[slot].next_carried;
}

void ObjectTable::reset() noexcept {
  for (std::uint32_t slot = 0; slot < size(); ++slot) {
    ObjectRecord& record = records_[slot];
    if (!record.alive) continue;
    if (!is_same(record.X_WO, record.description.X_WO)) note(changes_.moved, slot, kMoved);
    record.X_WO = record.commanded = record.description.X_WO;
    if (record.carrier == kNoIndex) continue;
    unlink(slot);
    find_bodies(slot);
  }
}

bool ObjectTable::is_alive(ObjectHandle object) const {
  return object.slot < size() && records_[object.slot].alive &&
         records_[object.slot].generation == object.generation;
}

bool ObjectTable::may_move(ObjectHandle object) const {
  if (!is_alive(object)) return false;
  const ObjectRecord& record = records_[object.slot];
  return !record.is_static() && !record.is_link() && record.carrier == kNoIndex;
}

std::uint32_t ObjectTable::slot_of(ObjectHandle object) const {
  if (!is_alive(object)) throw InputError("contact world: the object of a handle is gone, or never was");
  return object.slot;
}

ObjectHandle ObjectTable::find(std::string_view name) const {
  const auto known = slot_of_name_.find(name);
  if (known == slot_of_name_.end()) throw InputError("contact world: no object '" + std::string(name) + "'");
  return handle(known->second);
}

std::optional<std::uint32_t> ObjectTable::find_group(std::string_view name) const {
  const auto known = std::find(group_names_.begin(), group_names_.end(), name);
  if (known == group_names_.end()) return std::nullopt;
  return static_cast<std::uint32_t>(known - group_names_.begin());
}

std::uint32_t ObjectTable::group(std::string_view name) {
  if (const auto known = find_group(name)) return *known;
  const GroupName checked(name);  // one that could not be selected is no group
  if (group_names_.size() == kMostGroups) throw InputError("contact world: more than 64 groups");
  group_members_.reserve(kMostGroups);  // so that a name comes with its list
  group_names_.emplace_back(checked.text());
  group_members_.emplace_back();
  return static_cast<std::uint32_t>(group_names_.size() - 1);
}

std::vector<std::uint32_t> ObjectTable::groups(std::span<const std::string> names) {
  const std::size_t known = group_names_.size();
  std::vector<std::uint32_t> out;
  try {
    for (const std::string& name : names) out.push_back(group(name));
  } catch (...) {
    forget_groups_from(known);
    throw;
  }
  return out;
}

void ObjectTable::forget_groups_from(std::size_t first) noexcept {
  group_names_.resize(first), group_members_.resize(first);
}

std::pair<std::uint32_t, std::uint32_t> ObjectTable::groups_of(std::string_view first,
                                                               std::string_view second) {
  const auto a = find_group(first), b = find_group(second);
  if (a && b) return {*a, *b};
  const std::vector<std::uint32_t> both = groups(std::array{std::string(first), std::string(second)});
  return {both[0], both[1]};
}

bool Layout::is_exempt(const SolidPair& pair) const {
  return std::binary_search(exempt.begin(), exempt.end(), pair);
}

std::optional<SolidIndex> Layout::find(const Layout& other, SolidIndex solid) const {
  const ObjectHandle object = other.handle_of(solid);
  if (object.slot >= slots() || handles[object.slot] != object) return std::nullopt;
  return first_solid[object.slot] + (solid - other.first_solid_of(solid));
}

void Layout::reserve(std::size_t slots, std::size_t all_solids) {
  reserve_more(handles, slots), reserve_more(trees, slots), reserve_more(is_static, slots);
  reserve_more(slot_of, all_solids), reserve_more(solids, all_solids), reserve_more(X_OS, all_solids);
  reserve_more(levels, slots), reserve_more(proxy_trees, slots), reserve_more(slot_of_proxy, all_solids);
  reserve_more(first_solid, slots + 1), reserve_more(first_proxy, slots + 1);
}

void Layout::put(const ObjectTable& objects, std::uint32_t slot) {
  const ObjectRecord& object = objects[slot];
  const std::vector<PlacedHexahedron>& placed = object.description.tree->solids();
  const HexahedronTree& proxies = object.levels ? object.levels->box() : *object.description.tree;
  if (slot == slots()) {
    reserve(slots() + 1, solids.size() + placed.size());
    first_solid.push_back(first_solid.back() + static_cast<SolidIndex>(placed.size()));
    first_proxy.push_back(first_proxy.back() + static_cast<SolidIndex>(proxies.solids().size()));
    handles.emplace_back(), trees.emplace_back(), is_static.emplace_back();
    levels.emplace_back(), proxy_trees.emplace_back();
    slot_of_proxy.resize(first_proxy.back(), slot);
    slot_of.resize(first_solid.back(), slot);
    solids.resize(first_solid.back(), placed.front().solid), X_OS.resize(first_solid.back());
  }
  handles[slot] = object.alive ? objects.handle(slot) : ObjectHandle{};
  trees[slot] = object.description.tree.get();
  levels[slot] = object.levels.get(), proxy_trees[slot] = &proxies;
  is_static[slot] = object.is_static();
  for (std::size_t i = 0; i < placed.size(); ++i)
    solids[first_solid[slot] + i] = placed[i].solid, X_OS[first_solid[slot] + i] = placed[i].X_OS;
}

Layout make_layout(const ObjectTable& objects) {
  Layout out;
  std::size_t solids = 0;
  for (std::uint32_t slot = 0; slot < objects.size(); ++slot)
    solids += objects[slot].description.tree->solids().size();
  out.reserve(objects.size(), solids);
  out.first_solid.push_back(0), out.first_proxy.push_back(0);
  for (std::uint32_t slot = 0; slot < objects.size(); ++slot) out.put(objects, slot);
  return out;
}

// A few are put in their places, many merged.
constexpr std::size_t kFewPairs = 16;

void Layout::add_exempt(std::span<const SolidPair> pairs) {
  make_room(exempt, exempt.size() + pairs.size());
  if (pairs.size() <= kFewPairs) {
    for (const SolidPair& pair : pairs)
      exempt.insert(std::upper_bound(exempt.begin(), exempt.end(), pair), pair);
    return;
  }
  const auto before = static_cast<std::ptrdiff_t>(exempt.size());
  exempt.insert(exempt.end(), pairs.begin(), pairs.end());
  std::inplace_merge(exempt.begin(), exempt.begin() + before, exempt.end());
}

void Layout::remove_exempt(std::span<const SolidPair> pairs) {
  if (pairs.size() <= kFewPairs) {
    for (const SolidPair& pair : pairs) {
      const auto place = std::lower_bound(exempt.begin(), exempt.end(), pair);
      if (place != exempt.end() && *place == pair) exempt.erase(place);
    }
    return;
  }
  std::vector<SolidPair> left;
  std::set_difference(exempt.begin(), exempt.end(), pairs.begin(), pairs.end(), std::back_inserter(left));
  exempt = std::move(left);
}

std::vector<SolidPair> exempt_pairs(const Layout& layout, const SolidExemption& exemption) {
  const auto range = [&](ObjectHandle object, std::uint32_t solid) {
    const SolidIndex first = layout.first_solid[object.slot];
    return solid == kAllSolids ? std::pair{first, layout.first_solid[object.slot + 1]}
                               : std::pair{first + solid, first + solid + 1};
  };
  const auto [a, a_end] = range(exemption.a, exemption.solid_a);
  const auto [b, b_end] = range(exemption.b, exemption.solid_b);
  std::vector<SolidPair> out;
  for (SolidIndex i = a; i < a_end; ++i)
    for (SolidIndex j = b; j < b_end; ++j) out.push_back(i < j ? SolidPair{i, j} : SolidPair{j, i});
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace touchstone
