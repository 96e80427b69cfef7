#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/physics/solver/contact_problem.hpp"
#include "touchstone/physics/world/groups/group_state.hpp"

// The rows of a group's contact problem: three for each contact (its normal and two tangents), one for each
// drive and each end stop of a joint. Islands are solved from this data alone.

namespace touchstone::physics::stepping {

/// A body or mechanism as rows see it.
struct RowUnit {
  // A body: mass 0 says that it is a mechanism.
  double mass = 0.0;
  Matrix3 inverse_inertia_W = Matrix3::Zero();           // about its centre
  Vector3 middle_W = Vector3::Zero();                    // of its path over the piece: levers start there
  Vector3 v_W = Vector3::Zero(), w_W = Vector3::Zero();  // without impulses
  Vector3 change_v_W = Vector3::Zero(), change_w_W = Vector3::Zero();  // by its island's impulses
  Vector3 impulse_W = Vector3::Zero(), moment_W = Vector3::Zero();     // sum_impulses(); about middle_W
  Vector3 force_W = Vector3::Zero(), push_moment_W = Vector3::Zero();  // of gravity and pushes
  bool is_jointed = false;  // middle_W is the end of its path less half a step of its last velocity
  // A mechanism: views of its Arm.
  std::span<const double> M;  // its mass matrix, factored by factor_cholesky()
  std::span<double> change;   // of its rates, by impulses

  bool is_body() const { return mass > 0.0; }
  std::size_t width() const { return is_body() ? 6 : change.size(); }
};

/// A contact problem in its parts: velocities u = J M^-1 J^T x + b of impulses x, W never formed. Blocks are
/// contacts, then joint rows.
struct ContactRows {
  /// A mover at a contact.
  struct Side {
    std::uint32_t unit;  // kNoUnit: fixed or kinematic
    double sign;         // -1: A, 1: B
    Vector3 lever_W;     // a body's: from the middle of its path to where impulses act
    std::size_t first;   // a mechanism's: of its three rows in J and Y
  };
  struct Contact {
    std::size_t point;  // of the group
    Vector3 n_W, t1_W, t2_W;
    Side sides[2];
    double room;  // before its bodies meet, over the piece's length [m/s]: a part of b and of commanded
  };
  /// A row of a joint: of a drive, of its losses, an end stop; or a direction that a joint between movers
  /// holds. It acts on one unit or two.
  struct Joint {
    std::uint32_t unit, value;  // of a mechanism; kNoUnit: of the joint between movers `value`
    double sign;
    bool is_stop;
    Torque torque = Torque::drive;
    bool stops = false;       // it may come to rest where its impulse is within its bounds
    double share = 1.0;       // of its impulse, that is the drive's
    double before = 0.0;      // its velocity at the start of the piece
    double compliance = 0.0;  // u = W x + b + compliance x, as W has it [1/kg], [1/(kg m2)]
    std::uint32_t held = 0;   // of a joint between movers: which of its directions, if not is_axis
    bool is_axis = true;      // along the joint's axis, as a mechanism's
    // Parts of its row in J and Y.
    int count = 0;
    std::uint32_t units[2] = {0, 0};
    std::size_t first[2] = {0, 0};
  };

  std::vector<RowUnit> units;          // by unit; those of the group are set
  std::vector<std::uint32_t> members;  // units of the group, in order
  std::uint32_t first_mechanism = 0;   // its unit: bodies come before
  double length = 0.0;                 // of the piece that impulses act over [s]; 0: at once
  std::vector<Contact> contacts;
  std::vector<Joint> joints;
  std::vector<double> J, Y;  // of mechanisms and joints, and M^-1 J^T; then rows that are written out
  std::vector<double> b;     // velocities without impulses
  std::vector<double>
      commanded;          // by block: what b (a contact's along its normal) would be if all units stood still
  std::vector<double> x;  // impulses
  std::vector<double> u;  // velocities
  std::vector<double> friction;
  std::vector<ContactProblem::Bounds> bounds;  // by joint row

  void reserve(std::size_t contacts, std::size_t joint_rows, std::size_t units, std::size_t widest);
  std::size_t block_count() const { return contacts.size() + joints.size(); }
  std::size_t first_row(std::size_t block) const {
    return block < contacts.size() ? 3 * block : 2 * contacts.size() + block;
  }
  /// The first that the block acts on. @pre there is one
  std::uint32_t unit_of_block(std::size_t block) const;
  /// The diagonal entry of W of a joint's row, without compliance.
  double own_entry(std::size_t joint) const;
  /// Three entries of J.
  Vector3 vector_at(std::size_t first) const { return {J[first], J[first + 1], J[first + 2]}; }
  /// The impulse of a contact on B.
  Vector3 impulse_of(std::size_t contact) const;
  /// The impulse of a joint's row.
  double joint_impulse(std::size_t joint) const { return x[3 * contacts.size() + joint]; }
};

/// Which problem the rows make.
enum class Phase : std::uint8_t {
  impact,   ///< velocities at once, without forces
  forces,   ///< velocities after free flight over the piece
  parting,  ///< velocities that take overlap back over the step, without momentum
};

struct RowsWanted {
  Phase phase;
  double t;      // length of the piece [s]
  bool all;      // points and stops that are apart, too: they may be approached as far as they are
  bool is_anew;  // false: the rows last gathered, for a piece of another length from the same start
};

/// Writes a group's rows; x is the last step's forces.
void gather(const RowsWanted& wanted, const GroupState& group, StepContext& step, Movers& movers,
            ContactRows& rows);
/// The group's mass matrices, factored.
void factor_masses(const Group& group, Movers& movers);
/// Impulses of all rows on each unit of the group: RowUnit::impulse_W and moment_W, or change.
void sum_impulses(ContactRows& rows);

}  // namespace touchstone::physics::stepping
