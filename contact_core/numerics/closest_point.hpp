#pragma once

// Private: the point of conv{b_j - a_i} closest to the origin, by Gilbert, Johnson and
// Keerthi's iteration (IEEE J. Robotics and Automation 4(2), 1988), free of divisions.
//
// Why the integer version is right and ends: the simplex step picks a subset whose affine hull's closest
// point v lies in the relative interior of the subset (all weights > 0) and which no other simplex point
// beats (p.v >= v.v), so v is the closest point of the simplex. The loop ends when no vertex m of the
// difference has m.v < v.v, which is the optimality condition for the whole hull. Otherwise the new vertex
// makes |v| strictly smaller; a subset never returns, and there are finitely many. Every test is an integer's
// sign. The double version runs the same formulas, is allowed to be wrong, and only proposes the simplex the
// integer version starts from.

#include <array>
#include <span>
#include <type_traits>

#include "touchstone/contact_core/numerics/scalar_vector.hpp"

namespace touchstone::numerics {

struct VertexPair {
  int a, b;
  friend bool operator==(const VertexPair&, const VertexPair&) = default;
};

/// Vertices of the difference and where the closest point lies in them.
template <class S>
struct ClosestSimplex {
  int size = 0;
  std::array<VertexPair, 4> vertices;
  std::array<S, 4> weights;  ///< of the closest point, not normalised; not set when 4 contain the origin
  Vector<S> direction;       ///< along the closest point; zero when contains_origin
  S height;                  ///< direction . m, the same for all vertices of the simplex
  bool contains_origin = false;
};

/// The closest point of the affine hull of `points`, if it is in their relative interior.
template <class S>
bool interior_closest_point(std::span<const Vector<S>> points, ClosestSimplex<S>& out) {
  const Vector<S>& p = points[0];
  // Weights and direction by the simplex: a point, an edge, a triangle, a tetrahedron.
  if (points.size() == 1) {
    out.weights[0] = 1;
    out.direction = p;
  } else if (points.size() == 2) {
    const Vector<S> edge = points[1] - p;
    const S t = -dot(p, edge);
    const S rest = dot(edge, edge) - t;
    if (!(t > 0 && rest > 0)) return false;
    out.direction = cross(edge, cross(p, edge));
    out.weights[0] = rest;
    out.weights[1] = t;
  } else if (points.size() == 3) {
    const Vector<S>&q = points[1], &r = points[2];
    const Vector<S> normal = cross<S>(q - p, r - p);
    out.weights[0] = dot(cross(q, r), normal);
    out.weights[1] = dot(cross(r, p), normal);
    out.weights[2] = dot(cross(p, q), normal);
    if (!(out.weights[0] > 0 && out.weights[1] > 0 && out.weights[2] > 0)) return false;
    const S height = dot(normal, p);
    out.direction = height > 0 ? normal : (height < 0 ? -normal : Vector<S>{0, 0, 0});
  } else {
    const Vector<S>&q = points[1], &r = points[2], &s = points[3];
    const Vector<S> qr = cross(q, r), ps = cross(p, s);
    const S wp = dot(qr, s), wq = -dot(cross(p, r), s), wr = -dot(ps, q), ws = -dot(qr, p);
    const bool inside = (wp > 0 && wq > 0 && wr > 0 && ws > 0) || (wp < 0 && wq < 0 && wr < 0 && ws < 0);
    if (!inside) return false;
    out.direction = {0, 0, 0};
  }
  // For a tetrahedron that holds the origin all are 0.
  out.height = dot(out.direction, p);
  out.contains_origin = is_zero(out.direction);
  return true;
}

/// Reduces `simplex` to the subset that holds its point closest to the origin. False only for rounded
/// scalars.
template <class S>
bool reduce_simplex(std::span<const Vector<S>> a, std::span<const Vector<S>> b, ClosestSimplex<S>& simplex) {
  const int n = simplex.size;
  std::array<Vector<S>, 4> points;
  for (int k = 0; k < n; ++k) points[k] = b[simplex.vertices[k].b] - a[simplex.vertices[k].a];
  // The whole simplex first: a good start needs no other.
  for (unsigned mask = (1U << n) - 1U; mask > 0; --mask) {
    std::array<Vector<S>, 4> chosen;
    ClosestSimplex<S> trial;
    for (int k = 0; k < n; ++k) {
      if ((mask >> k & 1U) == 0) continue;
      chosen[trial.size] = points[k];
      trial.vertices[trial.size++] = simplex.vertices[k];
    }
    if (!interior_closest_point<S>({chosen.data(), static_cast<std::size_t>(trial.size)}, trial)) continue;
    bool closest = true;
    for (int k = 0; k < n && closest; ++k) {
      closest = (mask >> k & 1U) != 0 || dot(points[k], trial.direction) >= trial.height;
    }
    if (!closest) continue;
    simplex = std::move(trial);
    return true;
  }
  return false;
}

/// The vertex pair whose difference is lowest along `direction`.
template <class S>
VertexPair support(std::span<const Vector<S>> a, std::span<const Vector<S>> b, const Vector<S>& direction,
                   S& height) {
  VertexPair best{0, 0};
  S high = dot(a[0], direction), low = dot(b[0], direction);
  for (int i = 1; i < static_cast<int>(a.size()); ++i) {
    S value = dot(a[i], direction);
    if (value > high) {
      high = std::move(value);
      best.a = i;
    }
  }
  for (int j = 1; j < static_cast<int>(b.size()); ++j) {
    S value = dot(b[j], direction);
    if (value < low) {
      low = std::move(value);
      best.b = j;
    }
  }
  height = low - high;
  return best;
}

/// @param simplex  start: 1 to 4 vertex pairs; overwritten with the answer (exact for integers, a guess for
/// doubles).
template <class S>
void find_closest_point(std::span<const Vector<S>> a, std::span<const Vector<S>> b,
                        ClosestSimplex<S>& simplex) {
  constexpr bool kRounded = std::is_floating_point_v<S>;
  for (int iteration = 0; !kRounded || iteration < 24; ++iteration) {
    if (!reduce_simplex(a, b, simplex) || simplex.contains_origin) return;
    S height;
    const VertexPair lowest = support(a, b, simplex.direction, height);
    if (height >= simplex.height) return;
    if constexpr (kRounded) {
      for (int k = 0; k < simplex.size; ++k) {
        if (simplex.vertices[k] == lowest) return;
      }
      if (simplex.size == 4) return;
    }
    simplex.vertices[simplex.size++] = lowest;
  }
}

}  // namespace touchstone::numerics
