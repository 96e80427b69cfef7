#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/physics/world/groups/movers.hpp"

// Warm start: each contact of a step starts from the force that its feature had in the last one, and parts
// from the impulse that parted it then.

namespace touchstone::physics::stepping {

/// The figures of a contact that the next step takes over, on B.
struct ContactMemory {
  Vector3 force_W = Vector3::Zero();    ///< [N]
  Vector3 parting_W = Vector3::Zero();  ///< that took overlap back, without momentum [N s]

  ContactMemory& operator+=(const ContactMemory& other) {
    force_W += other.force_W, parting_W += other.parting_W;
    return *this;
  }
};

/// Contacts' memories from step to step, by their keys. Owns its memory.
class WarmStart {
 public:
  void reserve(std::size_t contacts);
  /// Finds the last step's memory for each contact. Memories whose names are gone go to the nearest points of
  /// their pair.
  void carry(std::span<const Contact> contacts, const Movers& movers);
  /// By carry().
  const ContactMemory& of(std::size_t contact) const { return carried_[contact].memory; }
  /// For the next step. @param p_A in A's frame [m]
  void keep(std::size_t index, const Contact& contact, const Vector3& p_A, const ContactMemory& memory) {
    next_[index] = {contact.key, contact.a, contact.b, p_A, memory, false};
  }
  /// The step was taken: the new memories become the last step's.
  void accept() { last_.swap(next_); }
  /// The step was not taken.
  void undo();

 private:
  /// A contact of the last step.
  struct Entry {
    std::uint64_t key = 0;
    Mover a = {}, b = {};
    Vector3 p_A = Vector3::Zero();  // in A's frame
    ContactMemory memory = {};
    bool is_taken = false;
  };
  struct Carried {
    ContactMemory memory;
    Vector3 p_A;  // in A's frame, where its pair's forces are passed on
  };

  void take_by_key(const Contact& contact, Carried& carried, std::size_t& next);
  void pass_on(std::span<const Contact> contacts, std::span<Carried> carried, const Movers& movers,
               std::size_t& next);

  std::vector<Entry> last_, next_;  // by contact
  std::vector<Carried> carried_;    // by contact
};

}  // namespace touchstone::physics::stepping
