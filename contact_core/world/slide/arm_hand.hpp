#pragma once

#include <span>

#include "touchstone/contact_core/motion/slide.hpp"
#include "touchstone/contact_core/world/objects/mechanism_mover.hpp"

// How a hand holds a mechanism by a tool frame, and what it feels there.

namespace touchstone {

/// Finds the metric of the slide that begins, M = diag(w) + J . S J: J of the tool frame and the stiffness S
/// along its axes as it stands. @pre arm.hand.
void weigh_by_hand(MechanismMover& arm);

/// The force and moment about the tool of what holds the arm back: of the rows `active` alone, for all of
/// what is left. Rows between links of its own make none.
void feel(const MechanismMover& arm, std::span<const SlideRow> rows, std::span<const JointRow> joint_rows,
          std::span<const int> active, Vector3& force_W, Vector3& moment_W);

/// With the arm as it stands now.
HandFeel feel_of(const MechanismMover& arm, ObjectHandle object, const Vector3& force_W,
                 const Vector3& moment_W);

}  // namespace touchstone
