#include "touchstone/contact_core/broadphase/native/tree_renewal.hpp"

#include <algorithm>

#include "touchstone/contact_core/memory/reserve_more.hpp"

namespace touchstone {

void TreeRenewal::set_objects(std::size_t objects) {
  if (objects != next_.slot_of.size()) resize_more(next_.slot_of, objects, kNowhere);
}

void TreeRenewal::reserve(std::uint32_t room) {
  const std::size_t next_room = ObjectTree::room_for(room);
  next_.tree.reserve(ObjectTree::room_for(room));
  reserve_more(next_.sphere_at, next_room);
}

bool TreeRenewal::can_begin(const ObjectTree& now) const {
  const std::uint32_t room = ObjectTree::room_for(now.size());
  return next_.tree.has_reserved(room) && next_.sphere_at.capacity() >= room;
}

void TreeRenewal::begin(const ObjectTree& now) noexcept {
  stage_ = Stage::room;
  at_ = 0, end_ = now.size();
  added_.clear();
  next_.tree.begin_anew(ObjectTree::room_for(end_));
}

void TreeRenewal::note_new(std::uint32_t object) {
  if (!is_under_way()) return;
  next_.slot_of[object] = kNowhere;
  added_.push_back(object);
}

void TreeRenewal::note_gone(std::uint32_t object) noexcept {
  if (stage_ < Stage::place || next_.slot_of[object] == kNowhere) return;
  next_.tree.erase(next_.slot_of[object]);
  next_.slot_of[object] = kNowhere;
}

void TreeRenewal::note_moved(std::uint32_t object, const SolidBounds& bounds) noexcept {
  if (stage_ >= Stage::place && next_.slot_of[object] != kNowhere) next_.place(object, bounds);
}

// Memory may be new to both lists: its pages cost more than all else. A sphere has less of it than a node.
bool TreeRenewal::make_room(std::size_t& work) noexcept {
  const std::size_t room = next_.tree.room(), most = (work + kBoxWork - 1) / kBoxWork;
  const bool has_nodes = next_.tree.make_nodes(most);
  const std::size_t spheres = next_.sphere_at.size();
  if (spheres < room) next_.sphere_at.resize(std::min(room, spheres + kSpheresOfANode * most));
  if (has_nodes && next_.sphere_at.size() >= room) return true;
  work = 0;
  return false;
}

bool TreeRenewal::copy(const ObjectTree& now, std::size_t& work) noexcept {
  for (; at_ < end_ && work > 0; ++at_, --work) {
    const std::uint32_t object = now.object_at(at_);
    if (object == ObjectTree::kNoObject) continue;
    next_.slot_of[object] = kNowhere;
    next_.tree.append(object);
  }
  return at_ == end_;
}

bool TreeRenewal::refit(std::size_t& work) noexcept {
  ObjectTree& tree = next_.tree;
  for (; level_ < tree.levels(); ++level_, at_ = 0) {
    for (; at_ < tree.children(level_) && take(work); ++at_) tree.refit_child(level_, at_);
    if (at_ < tree.children(level_)) return false;
  }
  return true;
}

}  // namespace touchstone
