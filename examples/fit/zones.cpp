#include <algorithm>

#include "touchstone/examples/fit/serves.hpp"

namespace touchstone::fitting {
namespace {

constexpr std::size_t kMostZones = 8;
constexpr double kLeastGain = 0.25;  // of a zone's room: what dividing it saves at least

bool is_empty(const Bounds& box) { return (box.high - box.low).minCoeff() < 0.0; }

double room_of(const Bounds& box) { return is_empty(box) ? 0.0 : (box.high - box.low).prod(); }

// Boxes first to end of a sequence, in one box.
struct Stretch {
  std::size_t first, end;
  Bounds box;
  std::size_t cut = 0;  // where to divide it
  double gain = 0.0;    // that this saves
};

Stretch stretch_of(std::span<const Bounds> boxes, std::size_t first, std::size_t end) {
  Stretch stretch{first, end, {}};
  // Rooms of all before a cut, then of all from it on.
  std::vector<double> before;
  for (std::size_t i = first; i < end; ++i) {
    stretch.box.add(boxes[i].low), stretch.box.add(boxes[i].high);
    before.push_back(room_of(stretch.box));
  }
  Bounds after;
  for (std::size_t i = end; i-- > first + 1;) {
    after.add(boxes[i].low), after.add(boxes[i].high);
    const double gain = before.back() - before[i - 1 - first] - room_of(after);
    if (gain > stretch.gain) stretch.gain = gain, stretch.cut = i;
  }
  if (stretch.gain < kLeastGain * room_of(stretch.box)) stretch.gain = 0.0;
  return stretch;
}

bool is_within(const Bounds& box, const Bounds& outer) {
  return (box.low - outer.low).minCoeff() >= 0.0 && (outer.high - box.high).minCoeff() >= 0.0;
}

}  // namespace

std::vector<Bounds> zones_about(std::span<const Bounds> swept, double by, const Bounds& part) {
  std::vector<Bounds> boxes;
  for (const Bounds& each : swept) {
    const Vector3 more = Vector3::Constant(by);
    const Bounds grown{(each.low - more).cwiseMax(part.low), (each.high + more).cwiseMin(part.high)};
    if (!is_empty(grown)) boxes.push_back(grown);
  }
  if (boxes.empty()) return {};
  // The stretch whose division saves most is divided next.
  std::vector<Stretch> stretches = {stretch_of(boxes, 0, boxes.size())};
  while (stretches.size() < kMostZones) {
    const auto most = std::max_element(stretches.begin(), stretches.end(),
                                       [](const Stretch& a, const Stretch& b) { return a.gain < b.gain; });
    if (most->gain <= 0.0) break;
    const Stretch whole = *most;
    *most = stretch_of(boxes, whole.first, whole.cut);
    stretches.push_back(stretch_of(boxes, whole.cut, whole.end));
  }
  // A way back is in the zone of the way there.
  std::vector<Bounds> zones;
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    const bool is_in_other = std::any_of(stretches.begin(), stretches.end(), [&](const Stretch& other) {
      const bool is_same = is_within(other.box, stretches[i].box);
      return &other != &stretches[i] && is_within(stretches[i].box, other.box) &&
             (!is_same || &other < &stretches[i]);
    });
    if (!is_in_other) zones.push_back(stretches[i].box);
  }
  return zones;
}

}  // namespace touchstone::fitting
