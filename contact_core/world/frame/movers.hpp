#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/memory/growing_list.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"
#include "touchstone/contact_core/world/model/world_model.hpp"

namespace touchstone {

/// The movers of a frame, by their roots' slots.
struct Movers {
  std::vector<std::uint32_t> roots;      ///< in motion, or taken along; ascending, each once
  std::vector<std::uint32_t> commanded;  ///< commanded or taken along in this frame; may name one twice
  std::vector<std::uint32_t> commanded_before;  ///< the same, one frame ago
  GrowingList<std::uint8_t> is_short;           ///< by slot: its commanded path was stopped in this frame

  /// @param anew forgets all commands.
  void take_room(std::size_t slots, bool anew);
  /// Adds a root that goes along with a mover. @pre it is no mover yet.
  void add_follower(std::uint32_t root);
};

/// Puts the movers of the last frame at rest; nothing is commanded yet.
void begin_frame(WorldModel& model, Movers& movers);

/// Lay the commanded paths; of several commands for a mover the last counts. A command for an object that was
/// removed or may not move, or to a pose or joint values that are not finite, becomes an event `refused`;
/// joint values beyond their limits are clamped and become events `at_limit`.
void accept(WorldModel& model, std::span<const MotionCommand> commands, Movers& movers,
            std::vector<ContactEvent>& events);
void accept(WorldModel& model, std::span<const JointCommand> commands, Movers& movers,
            std::vector<ContactEvent>& events);

/// After all commands: keeps the roots that are in motion, in order.
void order_movers(const WorldModel& model, Movers& movers);

/// After stops are known: notes the movers that were stopped before their path's end. @returns how many.
std::uint32_t note_short(const WorldModel& model, Movers& movers);

/// Ends the root's path where it stands.
void rest(WorldModel& model, std::uint32_t root);

}  // namespace touchstone
