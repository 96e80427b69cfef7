#include "touchstone/adapters/exact/signed_distance.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>
#include <vector>

#include "touchstone/adapters/exact/integer_vector.hpp"
#include "touchstone/adapters/exact/penetration.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"

namespace touchstone {
namespace {

using exact::ClosestSimplex;
using exact::Integer;
using exact::IntegerPair;
using exact::IntegerVector;

// The same order for (a,b) and (b,a): everything below sees one and the same question.
bool comes_after(const WorldVertices& a, const WorldVertices& b) {
  for (int i = 0; i < 8; ++i) {
    for (const auto axis : {&WorldVertices::x, &WorldVertices::y, &WorldVertices::z}) {
      const double u = (a.*axis)[i], v = (b.*axis)[i];
      if (u != v) return u > v;
    }
  }
  return false;
}

// Doubles relative to the first vertex of A, for a guess only.
std::array<exact::Vector<double>, 8> relative_vertices(const WorldVertices& v, const WorldVertices& origin) {
  std::array<exact::Vector<double>, 8> out;
  for (int i = 0; i < 8; ++i) out[i] = {v.x[i] - origin.x[0], v.y[i] - origin.y[0], v.z[i] - origin.z[0]};
  return out;
}

ClosestSimplex<Integer> closest_simplex(const IntegerPair& pair, const WorldVertices& a,
                                        const WorldVertices& b) {
  ClosestSimplex<double> guess;
  guess.size = 1;
  guess.vertices[0] = {0, 0};
  const auto ra = relative_vertices(a, a), rb = relative_vertices(b, a);
  exact::find_closest_point<double>(ra, rb, guess);
  ClosestSimplex<Integer> simplex;
  simplex.size = guess.size;
  simplex.vertices = guess.vertices;
  exact::find_closest_point<Integer>(pair.a, pair.b, simplex);
  return simplex;
}

// Sum of weights[k] * points[index of vertices[k]] over the sum of weights, in the world.
struct WeightedPoint {
  IntegerVector sum{0, 0, 0};
  Integer weight = 0;

  void add(const IntegerVector& p, const Integer& w) {
    sum = sum + exact::scaled(p, w);
    weight += w;
  }
  Vector3 in_world(const IntegerPair& pair) const {
    const IntegerVector p = sum + exact::scaled(pair.origin, weight);
    return {exact::round_ratio(p.x, weight, pair.exponent), exact::round_ratio(p.y, weight, pair.exponent),
            exact::round_ratio(p.z, weight, pair.exponent)};
  }
};

Vector3 unit(const IntegerVector& n) {
  const Integer square = dot(n, n);
  const auto component = [&](const Integer& c) { return exact::round_root(sgn(c), c * c, square, 0); };
  return {component(n.x), component(n.y), component(n.z)};
}

struct ExactDistance {
  IntegerVector direction;
  Integer height;  ///< the signed distance is height / |direction| * 2^exponent
  int tied;
};

double rounded(const ExactDistance& d, long exponent) {
  return exact::round_root(sgn(d.height), d.height * d.height, dot(d.direction, d.direction), exponent);
}

// Along the deepest direction n, the facet of the difference holds the origin's projection v = h n / n.n. Its
// weights over the facet's vertices give the witness points. All is multiplied by n.n to stay in integers.
void find_deepest_witnesses(const IntegerPair& pair, const ExactDistance& deepest, WeightedPoint& on_a,
                            WeightedPoint& on_b) {
  const IntegerVector& n = deepest.direction;
  const Integer square = dot(n, n);
  // The vertices of the facet.
  std::array<Integer, 8> along_a, along_b;
  for (int i = 0; i < 8; ++i) {
    along_a[i] = dot(pair.a[i], n);
    along_b[i] = dot(pair.b[i], n);
  }
  const Integer high = *std::max_element(along_a.begin(), along_a.end());
  const Integer low = *std::min_element(along_b.begin(), along_b.end());
  std::vector<IntegerVector> a, b;
  std::vector<int> index_a, index_b;
  for (int i = 0; i < 8; ++i) {
    if (along_a[i] == high) {
      a.push_back(exact::scaled(pair.a[i], square));
      index_a.push_back(i);
    }
    if (along_b[i] == low) {
      b.push_back(exact::scaled(pair.b[i], square) - exact::scaled(n, deepest.height));
      index_b.push_back(i);
    }
  }
  // Its point nearest v, as weights.
  ClosestSimplex<Integer> simplex;
  simplex.size = 1;
  simplex.vertices[0] = {0, 0};
  exact::find_closest_point<Integer>(a, b, simplex);
  for (int k = 0; k < simplex.size; ++k) {
    on_a.add(pair.a[index_a[simplex.vertices[k].a]], simplex.weights[k]);
    on_b.add(pair.b[index_b[simplex.vertices[k].b]], simplex.weights[k]);
  }
}

ExactDistance decide(const IntegerPair& pair, const WorldVertices& a, const WorldVertices& b,
                     ClosestSimplex<Integer>& simplex) {
  simplex = closest_simplex(pair, a, b);
  if (!simplex.contains_origin) return {simplex.direction, simplex.height, 1};
  exact::DeepestDirection deepest = exact::find_deepest_direction(pair, a, b);
  return {std::move(deepest.direction), std::move(deepest.height), deepest.tied};
}

PairClass class_of(const ExactDistance& d) {
  return d.height > 0 ? PairClass::separated : (d.height == 0 ? PairClass::touching : PairClass::penetrating);
}

/// Class and separation of solids whose cores are at this distance.
void set_rounded(const ExactDistance& d, const IntegerPair& pair, ExactResult& result) {
  const Integer heights = d.height * d.height, square = dot(d.direction, d.direction);
  const Integer radii = pair.radius * pair.radius * square;
  const int order = d.height <= 0 ? -1 : cmp(heights, radii);
  result.pair_class = order > 0    ? PairClass::separated
                      : order == 0 ? PairClass::touching
                                   : PairClass::penetrating;
  result.separation =
      order == 0 ? 0.0 : exact::round_root_less(sgn(d.height), heights, square, pair.radius, pair.exponent);
}

ExactResult in_order(const WorldVertices& a, double radius_a, const WorldVertices& b, double radius_b) {
  // The decision is exact, since integers stand for the vertices.
  const IntegerPair pair = exact::to_integers(a, b, radius_a, radius_b);
  ClosestSimplex<Integer> simplex;
  const ExactDistance distance = decide(pair, a, b, simplex);
  // Apart, the closest simplex has the witnesses; else the deepest faces have.
  WeightedPoint on_a, on_b;
  if (distance.height > 0) {
    for (int k = 0; k < simplex.size; ++k) {
      on_a.add(pair.a[simplex.vertices[k].a], simplex.weights[k]);
      on_b.add(pair.b[simplex.vertices[k].b], simplex.weights[k]);
    }
  } else {
    find_deepest_witnesses(pair, distance, on_a, on_b);
  }
  ExactResult result = {class_of(distance),
                        rounded(distance, pair.exponent),
                        unit(distance.direction),
                        distance.tied == 1,
                        distance.tied,
                        on_a.in_world(pair),
                        on_b.in_world(pair)};
  // Rounded solids reach beyond their vertices' hulls by their radii.
  if (pair.radius == 0) return result;
  set_rounded(distance, pair, result);
  result.p_A_W += radius_a * result.n_AB_W;
  result.p_B_W -= radius_b * result.n_AB_W;
  return result;
}

ExactDistance signed_distance(const WorldVertices& a, const WorldVertices& b, long& exponent) {
  const IntegerPair pair = exact::to_integers(a, b);
  exponent = pair.exponent;
  ClosestSimplex<Integer> simplex;
  return decide(pair, a, b, simplex);
}

Integer power(unsigned long base, long exponent) {
  Integer result;
  mpz_ui_pow_ui(result.get_mpz_t(), base, static_cast<unsigned long>(exponent));
  return result;
}

}  // namespace

ExactResult exact_signed_distance(const WorldVertices& a, const WorldVertices& b) {
  return exact_rounded_distance(a, 0.0, b, 0.0);
}

ExactResult exact_rounded_distance(const WorldVertices& a, double radius_a, const WorldVertices& b,
                                   double radius_b) {
  if (!comes_after(a, b)) return in_order(a, radius_a, b, radius_b);
  ExactResult result = in_order(b, radius_b, a, radius_a);
  result.n_AB_W = Vector3(0.0 - result.n_AB_W.x(), 0.0 - result.n_AB_W.y(), 0.0 - result.n_AB_W.z());
  std::swap(result.p_A_W, result.p_B_W);
  return result;
}

PairClass exact_pair_class(const WorldVertices& a, const WorldVertices& b) {
  long exponent = 0;
  return class_of(signed_distance(a, b, exponent));
}

bool exact_overlap(const WorldVertices& a, const WorldVertices& b) {
  return closest_simplex(exact::to_integers(a, b), a, b).contains_origin;
}

std::string exact_signed_distance_decimal(const WorldVertices& a, const WorldVertices& b, int digits) {
  long exponent = 0;
  const ExactDistance d = signed_distance(a, b, exponent);
  if (d.height == 0) return "0";
  Integer numerator = d.height * d.height, denominator = dot(d.direction, d.direction);
  if (exponent > 0) numerator *= power(4, exponent);
  if (exponent < 0) denominator *= power(4, -exponent);
  // sqrt(numerator / denominator) * 10^shift has `digits` or one more digits before the point; the estimate
  // of its size may be one off, then once again.
  const double log2_ratio = static_cast<double>(mpz_sizeinbase(numerator.get_mpz_t(), 2)) -
                            static_cast<double>(mpz_sizeinbase(denominator.get_mpz_t(), 2));
  long shift = digits - static_cast<long>(std::floor(log2_ratio * 0.150514997831990597));
  for (;; --shift) {
    Integer p = numerator, q = denominator, root;
    (shift > 0 ? p : q) *= power(100, std::labs(shift));
    p = 4 * p / q;  // the root of four times the value: its last bit is the half that rounding needs
    mpz_sqrt(root.get_mpz_t(), p.get_mpz_t());
    const Integer nearest = (root + 1) / 2;
    std::string text = nearest.get_str();
    const long length = static_cast<long>(text.size());
    if (length > digits) continue;
    if (length < digits) {
      shift += digits - length + 1;
      continue;
    }
    const long exponent10 = length - 1 - shift;
    if (digits > 1) text.insert(1, ".");
    return (d.height < 0 ? "-" : "") + text + "e" + std::to_string(exponent10);
  }
}

double exact_separation_along(const WorldVertices& a, const WorldVertices& b, const Vector3& n) {
  const bool usable = std::isfinite(n.x()) && std::isfinite(n.y()) && std::isfinite(n.z()) &&
                      (n.x() != 0.0 || n.y() != 0.0 || n.z() != 0.0);
  if (!usable) return kNaN;
  const IntegerPair pair = exact::to_integers(a, b);
  ExactDistance along;
  exact::to_integers(n, along.direction);
  exact::support<Integer>(pair.a, pair.b, along.direction, along.height);
  return rounded(along, pair.exponent);
}

double exact_surface_distance(const WorldVertices& solid, const Vector3& p) {
  WorldVertices point;
  point.x.fill(p.x());
  point.y.fill(p.y());
  point.z.fill(p.z());
  long exponent = 0;
  const ExactDistance d = signed_distance(solid, point, exponent);
  return std::abs(rounded(d, exponent));
}

}  // namespace touchstone
