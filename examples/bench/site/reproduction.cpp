#include "touchstone/examples/bench/site/reproduction.hpp"

#include <fmt/format.h>

#include <cmath>

#include "touchstone/examples/bench/site/site_text.hpp"
#include "touchstone/examples/compare_backends/page/html.hpp"

namespace touchstone::comparison {
namespace {

std::string text(const Vector3& v) { return fmt::format("({}, {}, {})", v.x(), v.y(), v.z()); }

std::string world_text(const WorldVertices& vertices) {
  std::string out;
  for (int i = 0; i < 8; ++i) out += "    " + text(vertices.vertex(i)) + "\n";
  return out;
}

std::string answer_text(const FiledAnswer& answer) {
  std::string out = answer.status;
  if (!std::isnan(answer.separation)) out += fmt::format(", signed distance {} m", answer.separation);
  if (is_finite(answer.n_AB_W)) out += ", normal " + text(answer.n_AB_W);
  return out;
}

}  // namespace

std::string pose_text(const Pose& X_WS) {
  std::string out = "  position " + text(X_WS.p) + "\n  rotation (rows)\n";
  for (int row = 0; row < 3; ++row)
    out += fmt::format("    [{}, {}, {}]\n", X_WS.R(row, 0), X_WS.R(row, 1), X_WS.R(row, 2));
  return out;
}

std::string solid_text(const Hexahedron& solid, const Pose& X_WS) {
  std::string out;
  if (solid.is_box()) {
    out = "box, full sides " + text(2 * solid.half_extents()) + "\n";
  } else {
    out = "convex hull of\n";
    for (const Vector3& vertex : solid.vertices()) out += "    " + text(vertex) + "\n";
  }
  return out + pose_text(X_WS);
}

PairSet one_case(const PairSet& set, std::size_t index) {
  const auto [a, b] = set.pairs[index];
  PairSet one;
  one.name = set.name;
  one.description = set.description;
  one.solids = {set.solids[a], set.solids[b]};
  one.poses = {set.poses[a], set.poses[b]};
  one.pairs = {{0, 1}};
  one.ids = {case_id(set, index)};
  return one;
}

std::string reproduction_text(const Entry& entry, QueryKind query, const FiledAnswer& answer,
                              const PairSet& set, const PairTruth& truth, const std::string& file) {
  const PosedPair posed = posed_pair(set, 0);
  return filled(site_text("reproduction.md"),
                {{"engine", entry.engine},
                 {"description", entry.description},
                 {"reason", answer.reason.empty() ? "inexact" : answer.reason},
                 {"query", std::string(to_string(query))},
                 {"case", answer.id},
                 {"a", solid_text(set.solids[0], set.poses[0])},
                 {"b", solid_text(set.solids[1], set.poses[1])},
                 {"world_a", world_text(posed.a)},
                 {"world_b", world_text(posed.b)},
                 {"class", std::string(to_string(truth.pair_class))},
                 {"distance", fmt::format("{}", truth.separation)},
                 {"normal", text(truth.n_AB_W) + (truth.normal_unique ? "" : " (one of several)")},
                 {"answer", answer_text(answer)},
                 {"cost", fmt::format("{:.3g}", shown_cost(answer.cost))},
                 {"cost_over_scale", fmt::format("{:.3g}", shown_cost(answer.cost / posed.scale))},
                 {"file", file}});
}

}  // namespace touchstone::comparison
