#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

/// @file
/// Events of pairs of solids that begin to touch, keep touching or part, from the contacts of successive
/// steps of any engine or narrowphase.

namespace touchstone::physics {

/// A contact point and its impulse over a step.
struct TouchPoint {
  SolidPair solids;   ///< A, B
  Vector3 p_W;        ///< half-way between the surfaces, at the step's start [m]
  Vector3 n_AB_W;     ///< unit, from A to B
  double separation;  ///< there [m]
  Vector3 impulse_W;  ///< on B over the step, impacts included [N s]
  Vector3 impact_W;   ///< on B, of impacts alone [N s]; NaN: not distinguished from forces
};

/// Change of a pair of solids in a step.
struct TouchEvent {
  /// The pair touches in the step, touched in the one before, or both.
  enum class Kind : std::uint8_t { began, persisted, ended };
  Kind kind = Kind::began;
  SolidPair solids;
  std::size_t first_point = 0, points = 0;  ///< of TouchEvents::points(); ended: none
  Vector3 impulse_W = Vector3::Zero();  ///< sum over the points, on B [N s]; asleep: of the last step awake
  Vector3 impact_W = Vector3::Zero();   ///< the same, of impacts alone
};
/// The enumerator's name.
std::string_view to_string(TouchEvent::Kind kind);

/// Finds events from the points of each step. A pair touches in a step if one of its points had an impulse in
/// it or was within the gap at its start, and once it touches, within twice the gap. Points further apart
/// have no effect. Does not allocate while no step has more points than reserved for or seen.
///
///     events.begin(); for (...) events.add(point); events.finish(sleeps);
class TouchEvents {
 public:
  /// @param gap [m], > 0
  explicit TouchEvents(double gap) : gap_(gap) {}
  void reserve(std::size_t points);

  /// Begins a step.
  void begin();
  /// Adds a point of the step, in any order.
  void add(const TouchPoint& point);
  /// @param sleeps whether a pair that touched in the last step and has no point in this one is not listed
  /// because both sleep: then it persists without points.
  template <class Sleeps>
  void finish(const Sleeps& sleeps) {
    sort_points();
    find_events();
    for (const TouchEvent& last : last_)
      if (last.kind != TouchEvent::Kind::ended && !is_listed(last.solids)) go_on(last, sleeps(last.solids));
    sort_events();
  }
  void finish() {
    finish([](const SolidPair&) { return false; });
  }
  /// Forgets all touches: nothing touched before the next step.
  void forget();

  /// The last step's events, by pair.
  std::span<const TouchEvent> events() const { return events_; }
  /// The points of pairs that touch, by pair, in the order in which they were added.
  std::span<const TouchPoint> points() const { return points_; }
  std::span<const TouchPoint> points_of(const TouchEvent& event) const {
    return points().subspan(event.first_point, event.points);
  }

 private:
  void sort_points();
  void find_events();
  void sort_events();
  void go_on(const TouchEvent& last, bool sleeps);
  bool is_listed(const SolidPair& pair) const;
  const TouchEvent* last_of(const SolidPair& pair) const;

  double gap_;
  std::vector<TouchPoint> added_, points_;
  std::vector<std::size_t> order_;  // of added_
  std::vector<TouchEvent> events_, last_;
  std::size_t listed_ = 0;  // events of pairs with points
};

}  // namespace touchstone::physics
