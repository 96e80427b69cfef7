#include "touchstone/contact_core/fit/parts/chords.hpp"

#include <algorithm>
#include <cmath>

namespace touchstone::fit {
namespace {

constexpr double kWidest = 0.3 * kTurn;  // of a chord
constexpr double kAtCorner = 1e-6;       // of a facet: what ends so near beyond a corner ends there
constexpr int kStarts = 16;              // in a facet's width
constexpr int kHalvings = 40;            // of a chord's width
constexpr int kDepths = 20;              // halvings of the limits

// How far the polygon is from the centre.
double radius_at(int facets, double turn) {
  const double width = kTurn / facets;
  return std::cos(0.5 * width) / std::cos(turn - std::floor(turn / width) * width - 0.5 * width);
}

// The end of the widest chord that is allowed.
double farthest_end(int facets, double begin, const ChordLimits& limits) {
  double low = begin, high = begin + kWidest;
  if (limits.allow(chord_between(facets, begin, high))) return high;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (limits.allow(chord_between(facets, begin, middle)) ? low : high) = middle;
  }
  const double width = kTurn / facets, corner = std::round(low / width) * width;
  return low >= corner && low - corner < 2.0 * kAtCorner * width ? corner : low;
}

// None where more than `most` are needed.
std::vector<Chord> chords_from(int facets, double start, const ChordLimits& limits, std::size_t most) {
  std::vector<Chord> chords;
  const double last = start + kTurn, near = kAtCorner * kTurn / facets;
  for (double begin = start; begin < last - near;) {
    if (chords.size() == most) return {};
    double end = farthest_end(facets, begin, limits);
    if (end > last - near) end = last;
    chords.push_back(chord_between(facets, begin, end));
    begin = end;
  }
  return chords;
}

}  // namespace

Chord chord_between(int facets, double begin, double end) {
  const double from = radius_at(facets, begin), to = radius_at(facets, end);
  const double x = to * std::cos(end) - from * std::cos(begin),
               y = to * std::sin(end) - from * std::sin(begin);
  Chord chord{begin, end, std::atan2(-x, y), 0.0, 0.0};
  chord.height = from * std::cos(begin - chord.out);
  // It is deepest at a corner.
  const double width = kTurn / facets;
  for (double corner = std::floor(begin / width + kAtCorner) + 1.0; (corner + kAtCorner) * width < end;
       corner += 1.0)
    chord.depth = std::max(chord.depth, std::cos(corner * width - chord.out) - chord.height);
  return chord;
}

// Beyond the outer wall the hexahedron's corners are on the rays through the chord's ends.
bool ChordLimits::allow(const Chord& chord) const {
  const double leaning = std::min(std::cos(chord.out - chord.begin), std::cos(chord.end - chord.out));
  return chord.depth <= inner && chord.depth <= outer * leaning;
}

std::vector<Chord> fewest_chords(int facets, const ChordLimits& limits) {
  // A chord a facet always goes around; the first start is at a corner.
  std::vector<Chord> best;
  double best_start = 0.0;
  for (int i = 0; i < kStarts; ++i) {
    const double start = i * kTurn / facets / kStarts;
    std::vector<Chord> chords =
        chords_from(facets, start, limits, best.empty() ? static_cast<std::size_t>(facets) : best.size() - 1);
    if (chords.empty()) continue;
    best = std::move(chords);
    best_start = start;
  }
  // The last one is shorter than the others, which may therefore be less deep.
  double low = 0.0, high = 1.0;
  for (int i = 0; i < kDepths; ++i) {
    const double share = 0.5 * (low + high);
    std::vector<Chord> chords =
        chords_from(facets, best_start, {share * limits.inner, share * limits.outer}, best.size());
    (chords.empty() ? low : high) = share;
    if (!chords.empty()) best = std::move(chords);
  }
  return best;
}

}  // namespace touchstone::fit
