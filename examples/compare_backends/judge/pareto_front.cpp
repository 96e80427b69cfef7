#include "touchstone/examples/compare_backends/judge/pareto_front.hpp"

#include <algorithm>

#include "touchstone/contact_core/geometry/constants.hpp"

namespace touchstone::comparison {

std::vector<std::string> pareto_front(const SetResult& set, QueryKind query) {
  struct Point {
    double error, ns;
    std::string name;
  };
  std::vector<Point> points;
  const std::size_t q = index_of(query);
  for (const BackendResult& backend : set.backends) {
    if (!backend.judged || !backend.judgement.wrongness[q].is_complete() || !backend.rows[q].single) continue;
    points.push_back({backend.judgement.cost[q].worst, backend.rows[q].single->median_ns, backend.name});
  }
  std::stable_sort(points.begin(), points.end(), [](const Point& x, const Point& y) {
    return x.error < y.error || (x.error == y.error && x.ns < y.ns);
  });
  std::vector<std::string> front;
  double fastest = kInfinity;
  for (const Point& point : points) {
    if (point.ns >= fastest) continue;
    fastest = point.ns;
    front.push_back(point.name);
  }
  return front;
}

}  // namespace touchstone::comparison
