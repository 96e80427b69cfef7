#pragma once

#include "touchstone/physics/world/rows/contact_rows.hpp"

// Events within a piece of a step: sliding ends, a joint reaches its drive's rate, a point or end stop
// arrives. The piece is cut there.

namespace touchstone::physics::stepping {

/// The first stop within a piece.
struct Stop {
  bool is_any = false;
  double when = 0.0;    // [s] from the start of the piece
  double speed = 0.0;   // the largest at the start of what stops [m/s], [rad/s]
  double missed = 0.0;  // the farthest that something is off at the end, as it stopped before [m], [rad]
};

/// How a piece's end is moved towards a stop.
struct StopSearch {
  int tries = 0;          // left
  bool is_probe = false;  // so short a piece that it shows how velocities go on
  bool is_aimed = false;  // a stop should be at its end
};

/// A group after it was tried to go on by t [s], its rows solved.
struct TriedPiece {
  const GroupState& group;
  const Movers& movers;
  const ContactRows& rows;
  const DynamicsWorld::Settings& settings;
  double t;
  double residual;  // that the rows were solved to [m/s]
};

/// Or drives that follow a rate, with limited torque.
bool has_brakes(const Group& group, const Movers& movers);
/// The first time at which sliding ends or a joint reaches its drive's rate.
Stop first_stop(const TriedPiece& piece);
/// Where the piece should end to be cut at a stop. @param stop of the piece. @param left of the step [s].
/// @param t out: the piece's new length. @return whether the piece is to be tried again.
bool seek_stop(const TriedPiece& piece, const Stop& stop, double left, double& t, StopSearch& search);
/// When, in the piece just taken, a point or stop that was apart first came together: on the parabola through
/// its distance and speed before and its distance now. `t` or more: none did.
double first_arrival(const GroupState& group, const Movers& movers, double gap, double t);

}  // namespace touchstone::physics::stepping
