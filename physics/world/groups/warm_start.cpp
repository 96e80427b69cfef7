#include "touchstone/physics/world/groups/warm_start.hpp"

#include <algorithm>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/physics/solver/reserved.hpp"

namespace touchstone::physics::stepping {
namespace {

/// Contacts mostly come in the same order: each is searched for in this many entries from where the one
/// before was found, so that many of them do not cost their square.
constexpr std::size_t kReach = 64;

/// Of its state: motions may not be updated yet.
Pose pose_of(const Mover& mover, const Movers& movers) {
  if (mover.kind != Mover::Kind::body) return movers.pose_of(mover);
  const Body& body = movers.bodies[mover.index];
  return body.body.pose(body.state);
}

}  // namespace

void WarmStart::reserve(std::size_t contacts) {
  reserve_written(last_, contacts);
  reserve_written(next_, contacts);
  reserve_written(carried_, contacts);
}

void WarmStart::undo() {
  for (Entry& entry : last_) entry.is_taken = false;
}

void WarmStart::carry(std::span<const Contact> contacts, const Movers& movers) {
  carried_.resize(contacts.size());
  next_.resize(contacts.size());
  std::size_t next = 0;
  for (std::size_t i = 0; i < contacts.size(); ++i) take_by_key(contacts[i], carried_[i], next);
  if (std::all_of(last_.begin(), last_.end(), [](const Entry& entry) { return entry.is_taken; })) return;
  next = 0;
  for (std::size_t i = 0, end = 0; i < contacts.size(); i = end) {
    while (end < contacts.size() && contacts[end].a == contacts[i].a && contacts[end].b == contacts[i].b)
      ++end;
    pass_on(contacts.subspan(i, end - i), std::span(carried_).subspan(i, end - i), movers, next);
  }
}

/// The force of the contact of this name, if there was one.
void WarmStart::take_by_key(const Contact& contact, Carried& carried, std::size_t& next) {
  carried.memory = {};
  if (contact.key == 0) return;
  std::size_t at = next;
  for (std::size_t i = std::min(kReach, last_.size()); i-- > 0;) {
    Entry& entry = last_[at];
    if (++at == last_.size()) at = 0;
    if (entry.key != contact.key) continue;
    next = at;
    carried.memory = entry.memory;
    entry.is_taken = true;
    return;
  }
}

/// Where corners lie on edges, a point's feature is named one way or another as rounding will have it, and
/// points come and go in the middle of edges: the forces of a pair's points whose names are gone go to the
/// points nearest to them, so that the pair is held as it was. @param contacts all of a pair. @param next
/// where the pairs before it were found.
void WarmStart::pass_on(std::span<const Contact> contacts, std::span<Carried> carried, const Movers& movers,
                        std::size_t& next) {
  const Contact& first = contacts.front();
  if (first.key == 0) return;
  // The pair's last entries are searched for from where the pair before was found.
  const auto is_pair = [&](const Entry& entry) { return entry.a == first.a && entry.b == first.b; };
  const std::size_t reach = std::min(kReach, last_.size());
  std::size_t skipped = 0;
  while (skipped < reach && !is_pair(last_[(next + skipped) % last_.size()])) ++skipped;
  if (skipped == reach) return;
  next = (next + skipped) % last_.size();
  // Each entry that was not taken gives its force to the nearest point.
  bool is_placed = false;
  for (std::size_t i = 0; i < last_.size(); ++i) {
    Entry& entry = last_[(next + i) % last_.size()];
    if (!is_pair(entry)) return;
    if (entry.is_taken) continue;
    if (!is_placed) {
      const Pose X_WA = pose_of(first.a, movers);
      for (std::size_t k = 0; k < contacts.size(); ++k)
        carried[k].p_A = rotate_back(X_WA.R, contacts[k].p_A_W - X_WA.p);
      is_placed = true;
    }
    Carried* nearest = &carried.front();
    for (Carried& other : carried)
      if (norm(entry.p_A - other.p_A) < norm(entry.p_A - nearest->p_A)) nearest = &other;
    nearest->memory += entry.memory;
    entry.is_taken = true;
  }
}

}  // namespace touchstone::physics::stepping
