#include "touchstone/examples/compare_backends/run/scenes/round_reference.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <queue>
#include <set>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/trigonometry.hpp"

namespace touchstone::comparison {
namespace {

constexpr std::size_t kMostAnswers = 20'000;
constexpr std::uint32_t kFirstSectors = 16;
// Halvings stop here: a sector of a metre's radius is then 3 nm wide.
constexpr std::uint32_t kMostSectors = 1u << 31;

// A solid of the set, or sector `index` of `count` equal ones of a tube.
struct Piece {
  const Tube* tube = nullptr;
  SolidIndex solid = 0;  // a tube's first facet has its pose
  std::uint32_t count = 1, index = 0;

  double half_angle() const { return std::numbers::pi / count; }
  double width() const { return tube == nullptr ? 0.0 : tube->outer_radius * half_angle(); }
  bool can_split() const { return tube != nullptr && count < kMostSectors; }
  Piece half(std::uint32_t which) const { return {tube, solid, count * 2, index * 2 + which}; }
};

// The corners of a sector: half widths at the distances `inner` and `outer` from the axis.
struct Corners {
  double inner, inner_half, outer, outer_half;
};

// Encloses the sector: chord of the bore, tangent of the outer circle.
Corners enclosing(const Piece& piece) {
  const auto [s, c] = sine_cosine(piece.half_angle());
  const Tube& tube = *piece.tube;
  return {tube.inner_radius * c, tube.inner_radius * s, tube.outer_radius, tube.outer_radius * (s / c)};
}

// Lies within the sector: tangent of the bore, chord of the outer circle. None where the bore's tangent
// leaves the outer circle.
std::optional<Corners> enclosed(const Piece& piece) {
  const auto [s, c] = sine_cosine(piece.half_angle());
  const Tube& tube = *piece.tube;
  if (tube.outer_radius * c <= tube.inner_radius) return std::nullopt;
  return Corners{tube.inner_radius, tube.inner_radius * (s / c), tube.outer_radius * c,
                 tube.outer_radius * s};
}

WorldVertices posed(const Piece& piece, const Corners& corners, const Pose& X_WS) {
  const auto [s, c] = sine_cosine((2.0 * piece.index + 1.0) * std::numbers::pi / piece.count);
  WorldVertices out;
  for (int bits = 0; bits < 8; ++bits) {
    const double u = bits & 4 ? corners.outer : corners.inner;
    const double half = bits & 4 ? corners.outer_half : corners.inner_half;
    const double v = bits & 2 ? half : -half;
    const Vector3 p_W =
        transform(X_WS, {u * c - v * s, u * s + v * c, bits & 1 ? piece.tube->high : piece.tube->low});
    out.x[bits] = p_W.x(), out.y[bits] = p_W.y(), out.z[bits] = p_W.z();
  }
  return out;
}

// Best first: the pair of pieces with the least lower bound is halved next.
class Search {
 public:
  Search(const PairSet& set, std::size_t frame, const Oracle& oracle)
      : set_(set), poses_(set.frame_poses(frame)), oracle_(oracle) {}

  void add(const Piece& a, const Piece& b) {
    const double low = separation(outside(a), outside(b));
    ++answers_;
    if (low >= high_) return;
    const std::optional<WorldVertices> in_a = inside(a), in_b = inside(b);
    if (a.tube == nullptr && b.tube == nullptr) {
      high_ = low;
    } else if (in_a && in_b) {
      high_ = std::min(high_, separation(*in_a, *in_b));
      ++answers_;
    }
    queue_.push({low, serial_++, a, b});
  }

  ClearanceBracket run() {
    while (!queue_.empty()) {
      const Pair next = queue_.top();
      const bool done = next.low >= high_ - kBracketWidth || high_ <= 0.0 || answers_ >= kMostAnswers;
      if (done || !(next.a.can_split() || next.b.can_split())) return {std::min(next.low, high_), high_};
      queue_.pop();
      const bool split_a = next.a.can_split() && (next.a.width() >= next.b.width() || !next.b.can_split());
      for (std::uint32_t which : {0u, 1u}) {
        if (split_a)
          add(next.a.half(which), next.b);
        else
          add(next.a, next.b.half(which));
      }
    }
    return {high_, high_};
  }

 private:
  struct Pair {
    double low;
    std::size_t serial;  // in ties the first found goes first
    Piece a, b;
    bool operator<(const Pair& other) const {
      return low > other.low || (low == other.low && serial > other.serial);
    }
  };

  double separation(const WorldVertices& a, const WorldVertices& b) const {
    return oracle_.truth(a, b).separation;
  }
  WorldVertices solid(const Piece& piece) const {
    WorldVertices out;
    world_vertices(set_.solids[piece.solid], poses_[piece.solid], out);
    return out;
  }
  WorldVertices outside(const Piece& piece) const {
    return piece.tube == nullptr ? solid(piece) : posed(piece, enclosing(piece), poses_[piece.solid]);
  }
  std::optional<WorldVertices> inside(const Piece& piece) const {
    if (piece.tube == nullptr) return solid(piece);
    const std::optional<Corners> corners = enclosed(piece);
    if (!corners) return std::nullopt;
    return posed(piece, *corners, poses_[piece.solid]);
  }

  const PairSet& set_;
  std::span<const Pose> poses_;
  const Oracle& oracle_;
  std::priority_queue<Pair> queue_;
  std::size_t serial_ = 0, answers_ = 0;
  double high_ = kInfinity;
};

// The whole of what a solid belongs to, in sectors where it is a facet.
std::vector<Piece> pieces_of(SolidIndex solid) { return {Piece{nullptr, solid, 1, 0}}; }
std::vector<Piece> pieces_of(const Tube& tube) {
  std::vector<Piece> pieces;
  for (std::uint32_t k = 0; k < kFirstSectors; ++k) pieces.push_back({&tube, tube.first, kFirstSectors, k});
  return pieces;
}

}  // namespace

ClearanceBracket true_clearance(const PairSet& set, std::size_t frame, std::span<const Tube> tubes,
                                const Oracle& oracle) {
  const auto tube_of = [&](SolidIndex solid) {
    const auto found = std::find_if(tubes.begin(), tubes.end(), [&](const Tube& tube) {
      return solid >= tube.first && solid < tube.first + tube.facets;
    });
    return found == tubes.end() ? nullptr : &*found;
  };
  Search search(set, frame, oracle);
  std::set<SolidPair> seen;
  for (const auto& [a, b] : set.pairs) {
    const Tube *tube_a = tube_of(a), *tube_b = tube_of(b);
    if (!seen.insert({tube_a ? tube_a->first : a, tube_b ? tube_b->first : b}).second) continue;
    for (const Piece& piece_a : tube_a ? pieces_of(*tube_a) : pieces_of(a))
      for (const Piece& piece_b : tube_b ? pieces_of(*tube_b) : pieces_of(b)) search.add(piece_a, piece_b);
  }
  return search.run();
}

}  // namespace touchstone::comparison
