#include "touchstone/adapters/exact/penetration.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"

// The least overlap is the distance from the origin to the boundary of the difference C = conv{b_j - a_i},
// and a ball inside C touches its boundary only inside facets. Facet normals of C are face normals of A, of B
// (negated), or cross products of an edge of A and one of B. Here every three vertices may be a face and
// every two an edge, so no hull has to be found, whatever its rank: a direction that is no facet normal has
// no larger height / |n|, and does no harm.
//
// Filter. Edges of each solid are divided by a power of two so that components are at most 1, and so are the
// vertices relative to A's first. With u = 2^-53, each such input has a relative error u (one subtraction)
// and, where it underflows, 2^-1074. A cross product's component is off by at most 8.1u, a component of n at
// most 2. A dot product of n with a vertex is off by 3 (8.1u + 2 * 4u) < 49u, a height (two of them,
// magnitude below 12) by 110u < kHeightError. The length of n is off by sqrt(3) * 8.1u + 4u |n| <
// kLengthError. Bounds on height / |n| follow; only what cannot be excluded by them is decided in integers.

namespace touchstone::exact {
namespace {

constexpr double kHeightError = 128 * kUnitRoundoff;
constexpr double kLengthError = 32 * kUnitRoundoff;
constexpr double kWiden = 8 * kUnitRoundoff;  // for the rounding of the bounds themselves

struct Edge {
  int from, to;
  Vector<double> along;
};

// Edges of length zero are left out: doubles differ exactly when their rounded difference is not zero.
struct EdgeList {
  std::array<Edge, 28> edges;
  int count = 0;

  Edge* begin() { return edges.data(); }
  Edge* end() { return edges.data() + count; }
  const Edge* begin() const { return edges.data(); }
  const Edge* end() const { return edges.data() + count; }
};

// The pair in doubles, rescaled; usable is false where the range of the coordinates defeats the error bounds.
struct FilterInput {
  std::array<double, 8> ax, ay, az, bx, by, bz;
  EdgeList edges_a, edges_b;
  bool usable = true;
};

double largest_component(const Vector<double>& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

Vector<double> difference(const WorldVertices& u, int i, const WorldVertices& v, int j) {
  return {u.x[i] - v.x[j], u.y[i] - v.y[j], u.z[i] - v.z[j]};
}

// A power of two 2^k with largest * 2^k in [1/2, 1), as two factors because k may be beyond a double's range.
struct PowerOfTwo {
  double first, second;
  double operator()(double value) const { return value * first * second; }
};

PowerOfTwo reciprocal_scale(double largest) {
  if (largest == 0.0) return {1.0, 1.0};
  int exponent = 0;
  std::frexp(largest, &exponent);
  return {std::ldexp(1.0, -exponent / 2), std::ldexp(1.0, -exponent - (-exponent / 2))};
}

Vector<double> scaled_by(const Vector<double>& v, PowerOfTwo s) { return {s(v.x), s(v.y), s(v.z)}; }

void fill_edges(const WorldVertices& v, EdgeList& list) {
  double largest = 0.0;
  for (int i = 0; i < 8; ++i) {
    for (int j = i + 1; j < 8; ++j) {
      const Vector<double> along = difference(v, j, v, i);
      if (is_zero(along)) continue;
      list.edges[list.count++] = {i, j, along};
      largest = std::max(largest, largest_component(along));
    }
  }
  const PowerOfTwo scale = reciprocal_scale(largest);
  for (Edge& edge : list) edge.along = scaled_by(edge.along, scale);
}

FilterInput make_filter_input(const WorldVertices& a, const WorldVertices& b) {
  FilterInput in;
  if (std::max(largest_coordinate(a), largest_coordinate(b)) >= 0x1p1000)
    in.usable = false;  // differences overflow
  fill_edges(a, in.edges_a);
  fill_edges(b, in.edges_b);
  double largest = 0.0;
  for (int i = 0; i < 8; ++i) {
    largest = std::max(
        {largest, largest_component(difference(a, i, a, 0)), largest_component(difference(b, i, a, 0))});
  }
  const PowerOfTwo scale = reciprocal_scale(largest);
  for (int i = 0; i < 8; ++i) {
    const Vector<double> p = scaled_by(difference(a, i, a, 0), scale),
                         q = scaled_by(difference(b, i, a, 0), scale);
    in.ax[i] = p.x, in.ay[i] = p.y, in.az[i] = p.z;
    in.bx[i] = q.x, in.by[i] = q.y, in.bz[i] = q.z;
  }
  return in;
}

// Bounds of height / |n|. Above 0 is impossible, the solids meet.
struct Bounds {
  double lower, upper;
};

Bounds bounds_of(double height, double length) {
  Bounds result{-kInfinity, 0.0};
  const double shortest = length - kLengthError;
  if (shortest > 0.0) result.lower = (height - kHeightError) / shortest * (1.0 + kWiden);
  if (height + kHeightError < 0.0) {
    result.upper = (height + kHeightError) / (length + kLengthError) * (1.0 - kWiden);
  }
  return result;
}

// Lengths squared below 2^-1022 are lost, far below kLengthError.
double length_of(const Vector<double>& n) { return std::sqrt(dot(n, n)); }

struct Heights {
  double along, against;  ///< of n and of -n
};

Heights heights_along(const FilterInput& in, const Vector<double>& n) {
  double low_a = kInfinity, high_a = -kInfinity, low_b = kInfinity, high_b = -kInfinity;
  for (int i = 0; i < 8; ++i) {
    const double u = in.ax[i] * n.x + in.ay[i] * n.y + in.az[i] * n.z;
    const double v = in.bx[i] * n.x + in.by[i] * n.y + in.bz[i] * n.z;
    low_a = std::min(low_a, u);
    high_a = std::max(high_a, u);
    low_b = std::min(low_b, v);
    high_b = std::max(high_b, v);
  }
  return {low_b - high_a, low_a - high_b};
}

// sign * (edge of first) x (edge of second), where the two may be of one solid (a face) or of both.
struct Candidate {
  const std::array<IntegerVector, 8>*first, *second;
  int first_from, first_to, second_from, second_to;
  int sign;
  double upper;
};

IntegerVector exact_direction(const Candidate& c) {
  const auto &p = *c.first, &q = *c.second;
  IntegerVector n = cross<Integer>(p[c.first_to] - p[c.first_from], q[c.second_to] - q[c.second_from]);
  return c.sign < 0 ? -n : n;
}

class Search {
 public:
  Search(const IntegerPair& pair, const WorldVertices& a, const WorldVertices& b)
      : pair_(pair), in_(make_filter_input(a, b)) {
    candidates_.reserve(256);
  }

  DeepestDirection run() {
    propose_faces(pair_.a, in_.edges_a);
    propose_faces(pair_.b, in_.edges_b);
    propose_edge_pairs();
    for (const Candidate& candidate : candidates_) {
      if (candidate.upper >= floor_) decide(candidate);
    }
    DeepestDirection result;
    if (best_.empty()) {
      result.direction = across_the_line();
      result.height = exact_height(result.direction);
      return result;
    }
    if (best_height_ == 0) keep_facets();
    result.direction = best_.front();
    for (const IntegerVector& n : best_) {
      if (is_after(n, result.direction)) result.direction = n;
    }
    result.height = exact_height(result.direction);  // on the chosen one's own scale
    result.tied = static_cast<int>(best_.size());
    return result;
  }

 private:
  void propose(const Candidate& candidate, double height, double length) {
    const Bounds bounds = in_.usable ? bounds_of(height, length) : Bounds{-kInfinity, 0.0};
    if (bounds.upper < floor_) return;
    floor_ = std::max(floor_, bounds.lower);
    candidates_.push_back(candidate);
    candidates_.back().upper = bounds.upper;
  }

  // Edges come sorted by their lower vertex, so two edges with one lower vertex span each triple once.
  void propose_faces(const std::array<IntegerVector, 8>& solid, const EdgeList& list) {
    const auto& edges = list.edges;
    for (int e = 0; e < list.count; ++e) {
      for (int f = e + 1; f < list.count && edges[f].from == edges[e].from; ++f) {
        const Vector<double> n = cross(edges[e].along, edges[f].along);
        const double length = length_of(n);
        const Heights heights = heights_along(in_, n);
        Candidate candidate{&solid, &solid, edges[e].from, edges[e].to, edges[f].from, edges[f].to, 1, 0.0};
        propose(candidate, heights.along, length);
        candidate.sign = -1;
        propose(candidate, heights.against, length);
      }
    }
  }

  // If the two edges make a facet with normal n, its height is n . (b_j - a_i) for any of their ends, and
  // that is not above 0 because the solids meet. That fixes n's sign and bounds it from above before any
  // support is looked for.
  void propose_edge_pairs() {
    for (const Edge& e : in_.edges_a) {
      for (const Edge& f : in_.edges_b) {
        const Vector<double> n = cross(e.along, f.along);
        const double span = (in_.bx[f.from] - in_.ax[e.from]) * n.x +
                            (in_.by[f.from] - in_.ay[e.from]) * n.y + (in_.bz[f.from] - in_.az[e.from]) * n.z;
        const double length = length_of(n);
        if (in_.usable && bounds_of(-std::abs(span), length).upper < floor_) continue;
        const Heights heights = heights_along(in_, n);
        Candidate candidate{&pair_.a, &pair_.b, e.from, e.to, f.from, f.to, 1, 0.0};
        if (!in_.usable || span <= kHeightError) propose(candidate, heights.along, length);
        candidate.sign = -1;
        if (!in_.usable || span >= -kHeightError) propose(candidate, heights.against, length);
      }
    }
  }

  // Touching, a direction can be as good as a facet's without being one. Where there is no facet (both solids
  // in a line but for one vertex, say), all stay.
  void keep_facets() {
    std::vector<IntegerVector> facets;
    for (const IntegerVector& n : best_) {
      if (is_facet(n)) facets.push_back(n);
    }
    if (!facets.empty()) best_ = std::move(facets);
  }

  // The difference's support set along n spans a plane: the edges of A's and of B's support sets are not all
  // parallel.
  bool is_facet(const IntegerVector& n) const {
    IntegerVector first{0, 0, 0};
    for (const auto* solid : {&pair_.a, &pair_.b}) {
      std::array<Integer, 8> along;
      for (int i = 0; i < 8; ++i)
        along[i] = solid == &pair_.a ? dot((*solid)[i], n) : Integer(-dot((*solid)[i], n));
      const auto top = std::max_element(along.begin(), along.end());
      const IntegerVector& base = (*solid)[top - along.begin()];
      for (int i = 0; i < 8; ++i) {
        if (along[i] != *top) continue;
        const IntegerVector edge = (*solid)[i] - base;
        if (is_zero(first)) {
          first = edge;
        } else if (!is_zero(cross(first, edge))) {
          return true;
        }
      }
    }
    return false;
  }

  Integer exact_height(const IntegerVector& n) const {
    Integer height;
    support<Integer>(pair_.a, pair_.b, n, height);
    return height;
  }

  void decide(const Candidate& candidate) {
    const IntegerVector n = exact_direction(candidate);
    if (is_zero(n)) return;
    for (const IntegerVector& known : best_) {
      if (is_parallel(known, n)) return;
    }
    if (in_.usable) {  // the direction is now exact: a cross product of nearly parallel edges has lost its
                       // noise
      const Vector<double> m = approximate(n);
      const Bounds bounds = bounds_of(heights_along(in_, m).along, length_of(m));
      if (bounds.upper < floor_) return;
      floor_ = std::max(floor_, bounds.lower);
    }
    Integer height = exact_height(n), square = dot(n, n);
    if (!best_.empty()) {  // -|h|/|n| against the best: the smaller |h|^2 / n.n wins
      const Integer mine = height * height * best_square_, theirs = best_height_ * best_height_ * square;
      if (mine > theirs) return;
      if (mine < theirs) best_.clear();
    }
    if (best_.empty()) {
      best_height_ = std::move(height);
      best_square_ = std::move(square);
    }
    best_.push_back(n);
  }

  static bool is_parallel(const IntegerVector& u, const IntegerVector& v) {
    return is_zero(cross(u, v)) && dot(u, v) > 0;
  }

  // All vertices of both solids on one line: any direction across it has height 0.
  IntegerVector across_the_line() const {
    IntegerVector line{0, 0, 0};
    for (const auto* solid : {&pair_.a, &pair_.b}) {
      for (const IntegerVector& v : *solid) {
        if (!is_zero(v)) line = v;
      }
    }
    if (line.y == 0 && line.z == 0) return {0, 0, 1};
    return cross<Integer>(line, {1, 0, 0});
  }

  const IntegerPair& pair_;
  FilterInput in_;
  std::vector<Candidate> candidates_;
  double floor_ = -kInfinity;  ///< the answer is at least this (in the filter's scale)
  std::vector<IntegerVector> best_;
  Integer best_height_, best_square_;
};

// u / |u| against v / |v| for one component.
int compare_component(const Integer& u, const Integer& uu, const Integer& v, const Integer& vv) {
  const int su = sgn(u), sv = sgn(v);
  if (su != sv || su == 0) return su - sv;
  return su * cmp(Integer(u * u * vv), Integer(v * v * uu));
}

}  // namespace

bool is_after(const IntegerVector& u, const IntegerVector& v) {
  const Integer uu = dot(u, u), vv = dot(v, v);
  int order = compare_component(u.x, uu, v.x, vv);
  if (order == 0) order = compare_component(u.y, uu, v.y, vv);
  if (order == 0) order = compare_component(u.z, uu, v.z, vv);
  return order > 0;
}

DeepestDirection find_deepest_direction(const IntegerPair& pair, const WorldVertices& a,
                                        const WorldVertices& b) {
  return Search(pair, a, b).run();
}

}  // namespace touchstone::exact
