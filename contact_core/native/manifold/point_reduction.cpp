#include "touchstone/contact_core/native/manifold/point_reduction.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace touchstone::native {
namespace {

constexpr double kSameArea = 1e-9;
constexpr int kMost = FlatPolygon::kMost;

double cross(const FlatPolygon& p, int o, int i, int j) {
  return (p.x[i] - p.x[o]) * (p.y[j] - p.y[o]) - (p.y[i] - p.y[o]) * (p.x[j] - p.x[o]);
}

double twice_area(const FlatPolygon& p) {
  double area = 0.0;
  for (int i = 1; i + 1 < p.count; ++i) area += cross(p, 0, i, i + 1);
  return std::abs(area);
}

double square_distance(const FlatPolygon& p, int i, int j) {
  const double x = p.x[i] - p.x[j], y = p.y[i] - p.y[j];
  return x * x + y * y;
}

void choose_pair(const FlatPolygon& p, int must, Choice& chosen) {
  double best = -1.0;
  for (int i = 0; i < p.count; ++i) {
    for (int j = i + 1; j < p.count; ++j) {
      if (must >= 0 && i != must && j != must) continue;
      const double worth = square_distance(p, i, j);
      if (worth > best * (1.0 + kSameArea)) best = worth, chosen[0] = i, chosen[1] = j;
    }
  }
}

/// The largest polygon of `wanted` corners that starts at `start` and goes on with the `rest` corners after
/// it.
class Chains {
 public:
  Chains(const FlatPolygon& polygon, int start, int rest, double same) : rest_(rest) {
    for (int i = 0; i < rest; ++i) corner_[i] = (start + 1 + i) % polygon.count;
    for (int i = 0; i < rest; ++i) {
      area_[0][i] = 0.0;
      for (int j = i + 1; j < rest; ++j) fan_[i][j] = cross(polygon, start, corner_[i], corner_[j]);
    }
    start_ = start, same_ = same;
  }

  /// Twice the area.
  double solve(int wanted, Choice& chosen) {
    const int links = wanted - 2;
    for (int k = 1; k <= links; ++k)
      for (int j = k; j < rest_; ++j) extend(k, j);
    int last = links;
    for (int j = links + 1; j < rest_; ++j)
      if (area_[links][j] > area_[links][last] + same_) last = j;
    const double area = area_[links][last];
    for (int k = links; k >= 0; --k) {
      chosen[k + 1] = corner_[last];
      last = k > 0 ? before_[k][last] : last;
    }
    chosen[0] = start_;
    return area;
  }

 private:
  void extend(int k, int j) {
    int best = k - 1;
    double best_area = area_[k - 1][best] + fan_[best][j];
    for (int i = k; i < j; ++i) {
      const double area = area_[k - 1][i] + fan_[i][j];
      if (area > best_area + same_) best = i, best_area = area;
    }
    area_[k][j] = best_area, before_[k][j] = static_cast<std::int8_t>(best);
  }

  int rest_, start_;
  double same_;
  std::array<int, kMost> corner_;
  std::array<std::array<double, kMost>, kMost> fan_, area_;
  std::array<std::array<std::int8_t, kMost>, kMost> before_;
};

}  // namespace

void choose_largest_polygon(const FlatPolygon& polygon, int wanted, int must, Choice& chosen) {
  if (wanted == 1) {
    chosen[0] = must >= 0 ? must : 0;
    return;
  }
  if (wanted == 2) return choose_pair(polygon, must, chosen);
  const double same = kSameArea * twice_area(polygon);
  if (must >= 0) {
    Chains(polygon, must, polygon.count - 1, same).solve(wanted, chosen);
    std::sort(chosen.begin(), chosen.begin() + wanted);
    return;
  }
  double best = -kInfinity;
  for (int start = 0; start + wanted <= polygon.count; ++start) {
    Choice candidate;
    const double area = Chains(polygon, start, polygon.count - 1 - start, same).solve(wanted, candidate);
    if (area > best + same) best = area, chosen = candidate;
  }
}

}  // namespace touchstone::native
