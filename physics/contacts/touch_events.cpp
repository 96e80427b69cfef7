#include "touchstone/physics/contacts/touch_events.hpp"

#include <algorithm>
#include <array>

namespace touchstone::physics {
namespace {

constexpr auto is_before = [](const TouchEvent& event, const SolidPair& pair) { return event.solids < pair; };

const TouchEvent* find(std::span<const TouchEvent> events, const SolidPair& pair) {
  const auto at = std::lower_bound(events.begin(), events.end(), pair, is_before);
  return at != events.end() && at->solids == pair ? &*at : nullptr;
}

}  // namespace

std::string_view to_string(TouchEvent::Kind kind) {
  constexpr std::array<std::string_view, 3> kNames{"began", "persisted", "ended"};
  return kNames[static_cast<std::size_t>(kind)];
}

void TouchEvents::reserve(std::size_t points) {
  added_.reserve(points);
  points_.reserve(points);
  order_.reserve(points);
  // Those that ended stand beside those that touch.
  events_.reserve(2 * points);
  last_.reserve(2 * points);
}

void TouchEvents::begin() {
  last_.swap(events_);
  added_.clear();
  points_.clear();
  events_.clear();
}

void TouchEvents::add(const TouchPoint& point) { added_.push_back(point); }

void TouchEvents::forget() {
  events_.clear();
  points_.clear();
}

/// Stable, without std::stable_sort's memory.
void TouchEvents::sort_points() {
  order_.resize(added_.size());
  for (std::size_t i = 0; i < order_.size(); ++i) order_[i] = i;
  std::sort(order_.begin(), order_.end(), [&](std::size_t i, std::size_t k) {
    return added_[i].solids == added_[k].solids ? i < k : added_[i].solids < added_[k].solids;
  });
}

const TouchEvent* TouchEvents::last_of(const SolidPair& pair) const {
  const TouchEvent* const last = find(last_, pair);
  return last != nullptr && last->kind != TouchEvent::Kind::ended ? last : nullptr;
}

bool TouchEvents::is_listed(const SolidPair& pair) const {
  return find(std::span(events_).first(listed_), pair) != nullptr;
}

/// Of the pairs that have points.
void TouchEvents::find_events() {
  for (std::size_t i = 0, end = 0; i < order_.size(); i = end) {
    const SolidPair pair = added_[order_[i]].solids;
    while (end < order_.size() && added_[order_[end]].solids == pair) ++end;
    const bool touched = last_of(pair) != nullptr;
    const double reach = touched ? 2.0 * gap_ : gap_;
    TouchEvent event{touched ? TouchEvent::Kind::persisted : TouchEvent::Kind::began, pair, points_.size()};
    for (std::size_t k = i; k < end; ++k) {
      const TouchPoint& point = added_[order_[k]];
      if (point.impulse_W == Vector3::Zero() && !(point.separation <= reach)) continue;
      points_.push_back(point);
      event.impulse_W += point.impulse_W;
      event.impact_W += point.impact_W;
    }
    event.points = points_.size() - event.first_point;
    if (event.points == 0 && !touched) continue;
    if (event.points == 0) event.kind = TouchEvent::Kind::ended;
    events_.push_back(event);
  }
  listed_ = events_.size();
}

/// A pair that touched in the last step and has no points in this one.
void TouchEvents::go_on(const TouchEvent& last, bool sleeps) {
  TouchEvent event = last;
  event.kind = sleeps ? TouchEvent::Kind::persisted : TouchEvent::Kind::ended;
  event.first_point = event.points = 0;
  if (!sleeps) event.impulse_W = Vector3::Zero();
  event.impact_W = Vector3::Zero();
  events_.push_back(event);
}

void TouchEvents::sort_events() {
  std::sort(events_.begin(), events_.end(),
            [](const TouchEvent& a, const TouchEvent& b) { return a.solids < b.solids; });
}

}  // namespace touchstone::physics
