#include "touchstone/contact_core/broadphase/native/object_forest.hpp"

namespace touchstone {

ObjectForest::ObjectForest(const SolidBounds& bounds, TaskRunner* threads)
    : bounds_(bounds), threads_(threads), slot_of_(bounds.objects()) {
  std::vector<std::uint32_t> members[kTrees];
  for (std::uint32_t object = 0; object < bounds.objects(); ++object) {
    slot_of_[object] = static_cast<std::uint32_t>(members[tree_of(object)].size());
    members[tree_of(object)].push_back(object);
  }
  for (int i = 0; i < kTrees; ++i) {
    trees_[i].sphere_at.resize(members[i].size());
    trees_[i].tree.resize(std::move(members[i]));
  }
}

void ObjectForest::erase(std::uint32_t object, bool was_static) {
  trees_[was_static ? kStatic : kMoving].tree.erase(slot_of_[object]);
}

void ObjectForest::insert(std::uint32_t object) {
  Tree& tree = trees_[tree_of(object)];
  if (slot_of_.size() <= object) slot_of_.resize(object + 1);
  std::uint32_t slot = tree.tree.insert(object);
  if (slot == ObjectTree::kNoObject) {
    tree.tree.make_room();
    tree.is_void = true;
    slot = tree.tree.insert(object);
  }
  slot_of_[object] = slot;
  tree.sphere_at.resize(std::max<std::size_t>(tree.sphere_at.size(), slot + 1));
  tree.moves_since_sort += kMovesOfNew;
}

void ObjectForest::update_all() noexcept {
  for (int i = 0; i < kTrees; ++i) sort(i);
  is_sorted_ = true;
  for (Tree& tree : trees_) refit(tree);
}

void ObjectForest::sort(int i) noexcept {
  Tree& tree = trees_[i];
  tree.moves_since_sort = 0;
  tree.is_void = false;
  const FloatFrame frame = tree.tree.sort(bounds_.object_spheres_W(), slot_of_);
  // Moving objects decide; static objects share its frame and would have to be refitted.
  const bool decides = i == kMoving || trees_[kMoving].tree.size() == 0;
  if (!decides || !(trees_[kStatic].tree.size() == 0 || has_outgrown(frame))) return;
  frame_ = frame;
  if (is_sorted_ && i == kMoving && !trees_[kStatic].is_void) refit(trees_[kStatic]);
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

void ObjectForest::refit(Tree& tree) noexcept {
  auto box_of = [&](std::uint32_t slot, std::uint32_t object) {
    tree.sphere_at[slot] = bounds_.object_spheres_W()[object];
    return bounds_.object_box(object);
  };
  tree.tree.refit(frame_, box_of, threads_);
}

// Sorting costs about as much as refitting; a tree whose objects have all moved once since is due.
void ObjectForest::update(std::span<const std::uint32_t> moved) noexcept {
  std::size_t moves[kTrees] = {};
  for (std::uint32_t object : moved) ++moves[tree_of(object)];
  bool one_by_one[kTrees];
  for (int i = 0; i < kTrees; ++i) {
    Tree& tree = trees_[i];
    tree.moves_since_sort += moves[i];
    const bool resort = tree.is_void || (moves[i] > 0 && tree.moves_since_sort >= tree.tree.size());
    one_by_one[i] = !resort && moves[i] <= tree.tree.size() / kFew;
    if (resort) sort(i);
    if (!one_by_one[i]) refit(tree);
  }
  for (std::uint32_t object : moved) {
    if (!one_by_one[tree_of(object)] || bounds_.is_gone(object)) continue;
    Tree& tree = trees_[tree_of(object)];
    tree.sphere_at[slot_of_[object]] = bounds_.object_spheres_W()[object];
    tree.tree.refit_one(slot_of_[object], bounds_.object_box(object));
  }
}

}  // namespace touchstone
