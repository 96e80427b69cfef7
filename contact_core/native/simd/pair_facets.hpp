#pragma once

#include "touchstone/contact_core/native/simd/distance_kernels.hpp"

// choose_facet<true>() of distance_kernels.hpp for a single pair: lanes are the facets, so that none is idle.
// Every value results from the same operations in the same order as in a batch, so the bits are the same.

namespace touchstone::native::TOUCHSTONE_ISA {

/// Facets in the order of choose_facet(), the last one twice.
struct FacetTable {
  static constexpr int kFacets = 15;
  int first[16] = {}, second[16] = {};  ///< generators k < l that span the facet
  int other[16][4] = {};                ///< the others, in order

  constexpr FacetTable() {
    int facet = 0;
    for (int i = 0; i < 6; ++i)
      for (int j = i + 1; j < 6; ++j, ++facet) add(facet, i, j);
    add(kFacets, 4, 5);
  }

 private:
  constexpr void add(int facet, int i, int j) {
    first[facet] = i, second[facet] = j;
    int count = 0;
    for (int p = 0; p < 6; ++p)
      if (p != i && p != j) other[facet][count++] = p;
  }
};
constexpr FacetTable kFacetTable;

/// One number of each generator: of 0 to 3, and of 4 and 5.
struct SixNumbers {
  Double4 low, high;

  template <int i, int j, int k, int l>
  TOUCHSTONE_INLINE Double4 at() const {
    return __builtin_shufflevector(low, high, i, j, k, l);
  }
};

struct SixVectors {
  SixNumbers x, y, z;

  template <int i, int j, int k, int l>
  TOUCHSTONE_INLINE Vector3Of<Double4> at() const {
    return {x.at<i, j, k, l>(), y.at<i, j, k, l>(), z.at<i, j, k, l>()};
  }
};

struct PairGenerators {
  SixVectors g;
  SixNumbers square;
  Vector3Of<Double4> T;

  TOUCHSTONE_INLINE explicit PairGenerators(const Zonotope<Double2>& W) {
    const Vector3Of<Double2>(&v)[6] = W.generator;
    const auto six = [](Double2 a, Double2 b, Double2 c, Double2 d, Double2 e, Double2 f) {
      return SixNumbers{Double4{a[0], b[0], c[0], d[0]}, Double4{e[0], f[0], f[0], f[0]}};
    };
    g = {six(v[0].x, v[1].x, v[2].x, v[3].x, v[4].x, v[5].x),
         six(v[0].y, v[1].y, v[2].y, v[3].y, v[4].y, v[5].y),
         six(v[0].z, v[1].z, v[2].z, v[3].z, v[4].z, v[5].z)};
    const Vector3Of<Double4> low = {g.x.low, g.y.low, g.z.low}, high = {g.x.high, g.y.high, g.z.high};
    square = {dot(low, low), dot(high, high)};
    T = {all<Double4>(W.T.x[0]), all<Double4>(W.T.y[0]), all<Double4>(W.T.z[0])};
  }
};

/// Of the facets: height |height| and |n|^2 as in choose_facet(), and what |n|^2 must exceed.
struct FacetHeights {
  double signed_square[16], n_square[16], thinnest[16];
};

template <int group, int other>
TOUCHSTONE_INLINE Double4 width_along(const PairGenerators& pair, const Vector3Of<Double4>& n) {
  constexpr const FacetTable& t = kFacetTable;
  constexpr int i = 4 * group;
  return magnitude(dot(
      n,
      pair.g.at<t.other[i][other], t.other[i + 1][other], t.other[i + 2][other], t.other[i + 3][other]>()));
}

template <int group>
TOUCHSTONE_INLINE void find_heights(const PairGenerators& pair, FacetHeights& out) {
  constexpr const FacetTable& t = kFacetTable;
  constexpr int i = 4 * group;
  // The generators that span the group's four facets.
  constexpr int a = t.first[i], b = t.first[i + 1], c = t.first[i + 2], d = t.first[i + 3];
  constexpr int e = t.second[i], f = t.second[i + 1], g = t.second[i + 2], h = t.second[i + 3];
  const Vector3Of<Double4> p = pair.g.at<a, b, c, d>(), q = pair.g.at<e, f, g, h>();
  const Vector3Of<Double4> n = accurate_cross(p, q);
  const Double4 squares = pair.square.at<a, b, c, d>() * pair.square.at<e, f, g, h>();
  // Widths of the zonotope along the normals, in the order of choose_facet().
  const Double4 n_square = dot(n, n);
  const Double4 width =
      ((width_along<group, 0>(pair, n) + width_along<group, 1>(pair, n)) + width_along<group, 2>(pair, n)) +
      width_along<group, 3>(pair, n);
  const Double4 height = magnitude(dot(n, pair.T)) - width;
  store(height * magnitude(height), out.signed_square + i);
  store(n_square, out.n_square + i);
  store(all<Double4>(kThinnestSquare) * squares, out.thinnest + i);
}

TOUCHSTONE_INLINE FacetChoice<Double2> choose_pair_facet(const Zonotope<Double2>& W) {
  const PairGenerators pair(W);
  FacetHeights facets;
  find_heights<0>(pair, facets), find_heights<1>(pair, facets);
  find_heights<2>(pair, facets), find_heights<3>(pair, facets);
  int best = 0;
  double best_height = -__builtin_inf(), best_square = 1.0;
  for (int f = 0; f < FacetTable::kFacets; ++f) {
    if (!(facets.signed_square[f] * best_square > best_height * facets.n_square[f])) continue;
    if (!(facets.n_square[f] > facets.thinnest[f])) continue;
    best_height = facets.signed_square[f], best_square = facets.n_square[f], best = f;
  }
  return {all<Double2>(kFacetTable.first[best]), all<Double2>(kFacetTable.second[best]),
          all<Double2>(best_height) > Double2{}};
}

}  // namespace touchstone::native::TOUCHSTONE_ISA
