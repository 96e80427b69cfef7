#pragma once

#include <cstddef>

#include "touchstone/physics/solver/work_budget.hpp"
#include "touchstone/physics/world/groups/contact_groups.hpp"
#include "touchstone/physics/world/groups/movers.hpp"

// The step in progress, as its stages share it.

namespace touchstone::physics::stepping {

/// The least speed of parting [m/s]: the last of an overlap would else take step after step.
inline constexpr double kLeastPartingSpeed = 1e-3;
/// Of the fastest parting: a point that moved by this share less than wanted is still parting.
inline constexpr double kShareOfParting = 1e-2;
/// Slow is what moves no faster than gravity makes it in so many steps.
inline constexpr double kSlowSteps = 2.0;

/// The same for all groups of a step.
struct StepContext {
  const DynamicsWorld::Settings& settings;
  double h;           // of the whole step [s]
  WorkBudget budget;  // of the group; its clock is the step's
  StepReport report = {};
  std::uint32_t unconverged_before = 0;  // the group
  bool is_soft = false;                  // the group overlaps: the soft answer does for it
  bool is_parted = false;                // the group, of alike masses, overlaps, be it less deep
  bool is_resting = false;               // the group of many contacts is slow: it is to come to rest
  double for_last_piece = 0.0;           // of the group's work: with less no other piece begins
  double spare = 0.0;                    // work beyond their own that is left to the step's groups

  bool is_bounded() const { return settings.accuracy == DynamicsWorld::Accuracy::bounded; }
  double slow_speed() const { return kSlowSteps * h * norm(settings.gravity_W); }  // [m/s]
  /// Work is spent, or a solve of the group did not come to an end: when stops and arrivals are is then not
  /// known well enough for more pieces and tries.
  bool is_work_over() const {
    return is_bounded() && (report.unconverged > unconverged_before || budget.is_spent());
  }
  /// The same, or what is left is for the piece that ends the group's step.
  bool is_time_for_last() const { return is_work_over() || budget.left() < for_last_piece; }
  /// Reports why the step is not taken, and for which contact, body or mechanism. Returns false.
  bool fail(StepFailure failure, std::size_t index) {
    report.failure = failure;
    report.failed_index = static_cast<std::uint32_t>(index);
    return false;
  }
};

/// A group's work in the step, in multiplications. Accuracy::exact: without end.
double work_of(const Group& group, const Movers& movers, const StepContext& step);

}  // namespace touchstone::physics::stepping
