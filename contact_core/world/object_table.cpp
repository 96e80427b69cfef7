#include "touchstone/contact_core/world/object_table.hpp"

#include <algorithm>
#include <utility>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

constexpr std::uint32_t kNone = 0xffffffff;
constexpr std::uint32_t kMostGroups = 64;

std::uint32_t solid_index(const HexahedronTree& tree, std::string_view name) {
  if (name.empty()) return kAllSolids;
  for (std::uint32_t i = 0; i < tree.solids().size(); ++i)
    if (tree.solids()[i].name == name) return i;
  throw InputError("object '" + tree.name() + "' has no hexahedron '" + std::string(name) + "'");
}

void add_exempt_pairs(const Layout& layout, const SolidExemption& exemption, std::vector<SolidPair>& out) {
  const auto range = [&](ObjectHandle object, std::uint32_t solid) {
    const std::uint32_t index = layout.index_of_slot(object.slot);
    const SolidIndex first = layout.first_solid[index];
    return solid == kAllSolids ? std::pair{first, layout.first_solid[index + 1]}
                               : std::pair{first + solid, first + solid + 1};
  };
  const auto [a, a_end] = range(exemption.a, exemption.solid_a);
  const auto [b, b_end] = range(exemption.b, exemption.solid_b);
  for (SolidIndex i = a; i < a_end; ++i)
    for (SolidIndex j = b; j < b_end; ++j) out.push_back(i < j ? SolidPair{i, j} : SolidPair{j, i});
}

}  // namespace

ObjectHandle ObjectTable::add(ObjectDescription description) {
  if (!description.tree) throw InputError("contact world: an object without hexahedra");
  const std::string& name = description.tree->name();
  validate_pose(description.X_WO, "object '" + name + "'");
  for (const ObjectRecord& record : records_)
    if (record.alive && record.name() == name) throw InputError("object '" + name + "': the name is taken");
  std::uint64_t groups = 0;
  for (const std::uint32_t group : this->groups(description.groups)) groups |= std::uint64_t{1} << group;

  std::uint32_t slot = 0;
  while (slot < size() && records_[slot].alive) ++slot;
  if (slot == size()) {
    records_.emplace_back();
    X_BO_.emplace_back();
    X_CO_.emplace_back();
  }
  ObjectRecord& record = records_[slot];
  const std::uint32_t generation = record.generation + 1;
  record = {};
  record.generation = generation;
  record.alive = true;
  record.X_WO = record.commanded = description.X_WO;
  record.body = record.root = slot;
  record.groups = groups;
  record.description = std::move(description);
  record.carrier = kNone;
  X_BO_[slot] = X_CO_[slot] = {};
  return {slot, generation};
}

void ObjectTable::check_removable(ObjectHandle object) const {
  const std::uint32_t slot = slot_of(object);
  if (records_[slot].carrier != kNone)
    throw InputError("object '" + records_[slot].name() + "' is latched to '" +
                     records_[records_[slot].carrier].name() + "': unlatch it before it is removed");
  for (const ObjectRecord& record : records_)
    if (record.alive && record.carrier == slot)
      throw InputError("object '" + records_[slot].name() + "' carries '" + record.name() +
                       "': unlatch it before it is removed");
}

void ObjectTable::remove(ObjectHandle object) {
  const ObjectRecord& record = records_[slot_of(object)];
  if (record.is_link())
    throw InputError("object '" + record.name() + "' is a link: its mechanism is removed as a whole");
  remove_link(object);
}

void ObjectTable::remove_link(ObjectHandle object) {
  check_removable(object);
  std::erase_if(exemptions_, [&](const SolidExemption& e) { return e.a == object || e.b == object; });
  records_[object.slot].alive = false;
}

void ObjectTable::make_link(ObjectHandle object, std::uint32_t mechanism, std::uint32_t link,
                            std::uint32_t lead) {
  ObjectRecord& record = records_[slot_of(object)];
  record.mechanism = mechanism;
  record.link = link;
  record.lead = lead;
  find_bodies();
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

void ObjectTable::exempt(const Exemption& pair) { exemptions_.insert(find(pair, {})); }

void ObjectTable::unexempt(const Exemption& pair) {
  if (exemptions_.erase(find(pair, {})) == 0)
    throw InputError("objects '" + records_[pair.a.slot].name() + "' and '" + records_[pair.b.slot].name() +
                     "' are not exempt by these names");
}

void ObjectTable::check_latch(std::uint32_t carrier, std::uint32_t carried) const {
  const ObjectRecord& record = records_[carried];
  if (record.carrier != kNone)
    throw InputError("object '" + record.name() + "' is already latched to '" +
                     records_[record.carrier].name() + "'");
  if (record.is_static()) throw InputError("object '" + record.name() + "' is static and cannot be carried");
  if (record.is_link())
    throw InputError("object '" + record.name() + "' is a link of a mechanism and cannot be carried");
  for (std::uint32_t i = carrier; i != kNone; i = records_[i].carrier)
    if (i == carried)
      throw InputError("latching '" + record.name() + "' to '" + records_[carrier].name() +
                       "' would close a cycle");
}

void ObjectTable::latch(ObjectHandle carrier, ObjectHandle carried, std::span<const Exemption> allowed) {
  const std::uint32_t to = slot_of(carrier), slot = slot_of(carried);
  check_latch(to, slot);
  std::set<SolidExemption> found;
  for (const Exemption& pair : allowed) found.insert(find(pair, carried));
  exemptions_.merge(found);
  records_[slot].carrier = to;
  X_CO_[slot] = compose(inverse(records_[to].X_WO), records_[slot].X_WO);
  find_bodies();
}

void ObjectTable::unlatch(ObjectHandle carried) {
  ObjectRecord& record = records_[slot_of(carried)];
  if (record.carrier == kNone) throw InputError("object '" + record.name() + "' is not latched");
  record.carrier = kNone;
  std::erase_if(exemptions_, [&](const SolidExemption& e) { return e.carried == carried; });
  find_bodies();
}

void ObjectTable::find_bodies() {
  for (std::uint32_t slot = 0; slot < size(); ++slot) {
    std::uint32_t body = slot;
    Pose X_BO;
    while (records_[body].carrier != kNone) {
      X_BO = compose(X_CO_[body], X_BO);
      body = records_[body].carrier;
    }
    records_[slot].body = body;
    records_[slot].root = records_[body].is_link() ? records_[body].lead : body;
    X_BO_[slot] = X_BO;
  }
}

void ObjectTable::reset() {
  for (ObjectRecord& record : records_) {
    if (!record.alive) continue;
    record.carrier = kNone;
    record.X_WO = record.commanded = record.description.X_WO;
  }
  std::erase_if(exemptions_, [](const SolidExemption& e) { return e.carried != ObjectHandle{}; });
  find_bodies();
}

bool ObjectTable::is_alive(ObjectHandle object) const {
  return object.slot < size() && records_[object.slot].alive &&
         records_[object.slot].generation == object.generation;
}

bool ObjectTable::may_move(ObjectHandle object) const {
  if (!is_alive(object)) return false;
  const ObjectRecord& record = records_[object.slot];
  return !record.is_static() && !record.is_link() && record.carrier == kNone;
}

std::uint32_t ObjectTable::slot_of(ObjectHandle object) const {
  if (!is_alive(object)) throw InputError("contact world: the object of a handle is gone, or never was");
  return object.slot;
}

ObjectHandle ObjectTable::find(std::string_view name) const {
  for (std::uint32_t slot = 0; slot < size(); ++slot)
    if (records_[slot].alive && records_[slot].name() == name) return handle(slot);
  throw InputError("contact world: no object '" + std::string(name) + "'");
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
  group_names_.emplace_back(checked.text());
  return static_cast<std::uint32_t>(group_names_.size() - 1);
}

std::vector<std::uint32_t> ObjectTable::groups(std::span<const std::string> names) {
  const std::size_t known = group_names_.size();
  std::vector<std::uint32_t> out;
  try {
    for (const std::string& name : names) out.push_back(group(name));
  } catch (const InputError&) {
    group_names_.resize(known);
    throw;
  }
  return out;
}

bool Layout::is_exempt(const SolidPair& pair) const {
  return std::binary_search(exempt.begin(), exempt.end(), pair);
}

std::uint32_t Layout::index_of_slot(std::uint32_t slot) const {
  return static_cast<std::uint32_t>(std::lower_bound(slots.begin(), slots.end(), slot) - slots.begin());
}

std::optional<SolidIndex> Layout::find(const Layout& other, SolidIndex solid) const {
  const ObjectHandle object = other.handle_of(solid);
  const std::uint32_t index = index_of_slot(object.slot);
  if (index == slots.size() || handles[index] != object) return std::nullopt;
  return first_solid[index] + (solid - other.first_solid_of(solid));
}

Layout make_layout(const ObjectTable& objects) {
  Layout out;
  for (std::uint32_t slot = 0; slot < objects.size(); ++slot) {
    const ObjectRecord& object = objects[slot];
    if (!object.alive) continue;
    out.slots.push_back(slot);
    out.handles.push_back(objects.handle(slot));
    out.first_solid.push_back(static_cast<SolidIndex>(out.solids.size()));
    out.trees.push_back(object.description.tree.get());
    out.is_static.push_back(object.is_static());
    for (const PlacedHexahedron& placed : object.description.tree->solids()) {
      out.slot_of.push_back(slot);
      out.solids.push_back(placed.solid);
      out.X_OS.push_back(placed.X_OS);
    }
  }
  out.first_solid.push_back(static_cast<SolidIndex>(out.solids.size()));
  return out;
}

std::vector<SolidPair> exempt_pairs(const ObjectTable& objects, const Layout& layout) {
  std::vector<SolidPair> out;
  for (const SolidExemption& exemption : objects.exemptions()) add_exempt_pairs(layout, exemption, out);
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

}  // namespace touchstone
