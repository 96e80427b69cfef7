#include "touchstone/contact_core/broadphase/native/object_forest.hpp"

#include <algorithm>

#include "touchstone/contact_core/memory/reserve_more.hpp"

namespace touchstone {

ObjectForest::ObjectForest(const SolidBounds& bounds, TaskRunner* threads)
    : bounds_(bounds), threads_(threads) {
  std::vector<std::uint32_t> members[kTrees];
  for (Tree& tree : trees_) resize_more(tree.now.slot_of, bounds.objects());
  for (std::uint32_t object = 0; object < bounds.objects(); ++object) {
    const int i = tree_of(object);
    trees_[i].now.slot_of[object] = static_cast<std::uint32_t>(members[i].size());
    members[i].push_back(object);
  }
  for (int i = 0; i < kTrees; ++i) {
    trees_[i].now.tree = ObjectTree(members[i]);
    reserve(trees_[i]);
  }
  grid_.reserve(bounds.objects());
}

/// For as many slots as there are; and for its renewal, unless that has begun with what it needs.
void ObjectForest::reserve(Tree& tree) {
  const std::uint32_t room = tree.now.tree.room();
  if (tree.now.sphere_at.size() < room) resize_more(tree.now.sphere_at, room);
  tree.renewal.set_objects(tree.now.slot_of.size());
  if (tree.renewal.is_under_way()) return;
  tree.renewal.reserve(room);
  tree.sort.reserve(ObjectTree::room_for(room));
}

void ObjectForest::erase(std::uint32_t object, bool was_static) {
  Tree& tree = trees_[was_static ? kStatic : kMoving];
  grid_.note_changes();
  tree.now.tree.erase(tree.now.slot_of[object]);
  tree.renewal.note_gone(object);
}

void ObjectForest::insert(std::uint32_t object) {
  grid_.reserve(bounds_.objects());  // which knows none that comes: if it was there, it was erased
  for (Tree& tree : trees_)
    if (object >= tree.now.slot_of.size()) resize_more(tree.now.slot_of, object + 1);
  Tree& tree = trees_[tree_of(object)];
  std::uint32_t slot = tree.now.tree.insert(object);
  if (slot == ObjectTree::kNoObject) {
    tree.now.tree.make_room();
    tree.renewal.stop();
    tree.is_void = true;
    slot = tree.now.tree.insert(object);
  }
  for (Tree& each : trees_) reserve(each);
  tree.now.slot_of[object] = slot;
  tree.renewal.note_new(object);
  tree.new_moves += kMovesOfNew;
}

void ObjectForest::update_all() noexcept {
  has_grid_ = false;
  for (int i = 0; i < kTrees; ++i) sort(i);
  is_sorted_ = true;
  for (Tree& tree : trees_) refit(tree);
}

void ObjectForest::sort(int i) noexcept {
  Tree& tree = trees_[i];
  ++sorts_;
  tree.moves_since_sort = tree.new_moves = 0;
  tree.is_void = false;
  tree.renewal.stop();
  const FloatFrame frame = tree.now.tree.sort(tree.sort, bounds_.object_spheres_W(), tree.now.slot_of);
  if (!decides_frame(i) || !(trees_[kStatic].now.tree.size() == 0 || has_outgrown(frame))) return;
  frame_ = frame;
  for (Tree& each : trees_) each.renewal.stop();
  if (is_sorted_ && i == kMoving && !trees_[kStatic].is_void) refit(trees_[kStatic]);
}

/// Moving objects decide; static objects share their frame and would have to be refitted.
bool ObjectForest::decides_frame(int i) const noexcept {
  return i == kMoving || trees_[kMoving].now.tree.size() == 0;
}

// Floats are about 2^-24 of their distance from the origin: a frame serves until that shows.
bool ObjectForest::has_outgrown(const FloatFrame& fit) const noexcept {
  for (int i = 0; i < 3; ++i) {
    const double growth = fit.scale(i) / frame_.scale(i);
    const double shift = (fit.origin(i) - frame_.origin(i)) * frame_.scale(i);
    if (!(growth > 0.125 && growth < 8.0 && std::abs(shift) < 4096.0)) return true;
  }
  return false;
}

/// Whether all must be sorted in another frame. Where no other tree is in the old one, it changes here.
bool ObjectForest::needs_frame(int i, const FloatFrame& fit) noexcept {
  if (!decides_frame(i) || !has_outgrown(fit)) return false;
  if (!trees_[i].is_void || trees_[1 - i].now.tree.size() > 0) return true;
  frame_ = fit;
  return false;
}

void ObjectForest::refit(Tree& tree) noexcept {
  auto box_of = [&](std::uint32_t slot, std::uint32_t object) {
    tree.now.sphere_at[slot] = bounds_.object_spheres_W()[object];
    return bounds_.object_box(object);
  };
  tree.now.tree.refit(frame_, box_of, threads_);
}

void ObjectForest::sort_by_place(std::span<std::uint32_t> objects,
                                 std::vector<std::uint64_t>& keys) const noexcept {
  keys.clear();
  for (const std::uint32_t object : objects) {
    const bool is_gone = bounds_.is_gone(object);
    const std::uint32_t place = is_gone     ? 0
                                : has_grid_ ? grid_.place_of(bounds_.object_spheres_W()[object])
                                            : slot_of(object);
    keys.push_back(std::uint64_t{place} << 32 | object);
  }
  std::sort(keys.begin(), keys.end());
  for (std::size_t i = 0; i < keys.size(); ++i) objects[i] = static_cast<std::uint32_t>(keys[i]);
}

// Sorting costs about as much as refitting; a tree whose objects have all moved once since is due. Where few
// move at a time, that is too much for the one update in which it falls due: it is renewed bit by bit.
void ObjectForest::update(std::span<const std::uint32_t> moved) noexcept {
  // Moves are counted by tree.
  std::size_t moves[kTrees] = {};
  for (std::uint32_t object : moved) ++moves[tree_of(object)];
  const bool is_many = moves[kMoving] > trees_[kMoving].now.tree.size() / kFew;
  has_grid_ = update_grid(moved, is_many);
  // Each tree is sorted anew, refitted, or updated object by object.
  bool one_by_one[kTrees];
  for (int i = 0; i < kTrees; ++i) {
    Tree& tree = trees_[i];
    const bool few = moves[i] <= tree.now.tree.size() / kFew;
    moves[i] += tree.new_moves;
    tree.moves_since_sort += moves[i];
    tree.new_moves = 0;
    if (has_grid_ && i == kMoving) {
      if (is_many) tree.renewal.stop();
      tree.is_void = true, one_by_one[i] = false;
      continue;
    }
    const bool is_due = moves[i] > 0 && tree.moves_since_sort >= tree.now.tree.size();
    const bool renews = few && (tree.renewal.is_under_way() || tree.renewal.can_begin(tree.now.tree));
    const bool resort = tree.is_void || (is_due && !renews);
    one_by_one[i] = !resort && few;
    if (resort) sort(i);
    if (!one_by_one[i]) tree.renewal.stop(), refit(tree);
  }
  // Objects are placed one by one in trees of which few objects moved.
  const bool any = (one_by_one[kMoving] && moves[kMoving] > 0) || (one_by_one[kStatic] && moves[kStatic] > 0);
  if (any) place_one_by_one(moved, one_by_one);
  // Such trees also go on with their renewal.
  for (int i = 0; i < kTrees; ++i)
    if (one_by_one[i] && moves[i] > 0) renew(i, moves[i]);
  if (has_grid_ && !is_many) renew_behind_grid(moved, moves[kMoving]);
}

/// Where many move, the grid may do without trees, static objects among its own unless they are too many; and
/// where few move after that, until the tree is made anew. @returns whether it serves.
bool ObjectForest::update_grid(std::span<const std::uint32_t> moved, bool is_many) noexcept {
  if (bounds_.on_paths() || trees_[kStatic].now.tree.size() > trees_[kMoving].now.tree.size()) return false;
  if (!bounds_.are_single()) return false;  // one of several solids may have come since it was built
  if (is_many) return grid_.build(bounds_, threads_);
  return has_grid_ && (moved.empty() || grid_.move(bounds_, moved) || grid_.build(bounds_, threads_));
}

void ObjectForest::renew_behind_grid(std::span<const std::uint32_t> moved, std::size_t moves) noexcept {
  Tree& tree = trees_[kMoving];
  for (const std::uint32_t object : moved)
    if (!bounds_.is_gone(object) && tree_of(object) == kMoving) tree.renewal.note_moved(object, bounds_);
  if (!moved.empty()) renew(kMoving, moves);
  has_grid_ = tree.is_void;
}

void ObjectForest::place_one_by_one(std::span<const std::uint32_t> moved,
                                    const bool (&one_by_one)[kTrees]) noexcept {
  constexpr std::size_t kAhead = 8;
  for (std::size_t i = 0; i < moved.size(); ++i) {
    if (i + kAhead < moved.size()) {
      const std::uint32_t next = moved[i + kAhead];
      if (!bounds_.is_gone(next)) trees_[tree_of(next)].now.prefetch(next);
    }
    const std::uint32_t object = moved[i];
    Tree& tree = trees_[tree_of(object)];
    if (!one_by_one[tree_of(object)] || bounds_.is_gone(object)) continue;
    tree.now.place(object, bounds_);
    tree.renewal.note_moved(object, bounds_);
  }
}

void ObjectForest::renew(int i, std::size_t moves) noexcept {
  Tree& tree = trees_[i];
  if (!tree.renewal.is_under_way()) {
    const bool is_due = tree.is_void || 4 * tree.moves_since_sort >= 3 * std::size_t{tree.now.tree.size()};
    if (!is_due) return;
    if (!tree.renewal.can_begin(tree.now.tree)) return;  // nothing comes any more: sorted at once
    tree.moves_since_sort = 0;
    tree.renewal.begin(tree.now.tree);
  }
  const auto belongs = [&](std::uint32_t object) { return !bounds_.is_gone(object) && tree_of(object) == i; };
  const auto outgrown = [&](const FloatFrame& fit) { return needs_frame(i, fit); };
  const TreeRenewal::Progress progress = tree.renewal.go_on(
      tree.now, bounds_, frame_, tree.sort, kWorkPerMove * moves + kLeastWork, belongs, outgrown);
  if (progress == TreeRenewal::Progress::goes_on) return;
  if (progress == TreeRenewal::Progress::done) {
    ++renewals_;
    tree.is_void = false;
    return;
  }
  sort(i);
  refit(tree);
}

}  // namespace touchstone
