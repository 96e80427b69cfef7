#include "touchstone/examples/bench/site/path_cell.hpp"

#include "touchstone/examples/bench/site/counts.hpp"
#include "touchstone/examples/compare_backends/judge/path_result.hpp"

namespace touchstone::comparison {
namespace {

FiledPath path_of(const Json& json) {
  FiledPath path;
  path.id = json.at("path");
  path.reason = json.at("reason");
  path.s = number_of(json.at("stops_at_s"));
  path.cost = number_of(json.at("cost_m"));
  path.cost_over_scale = number_of(json.at("cost_over_S"));
  return path;
}

bool is_early(const FiledPath& path) { return path.reason.empty() && path.cost_over_scale >= kEarlyFrom; }

}  // namespace

FiledPathSet path_set_of(const Json& json) {
  FiledPathSet set;
  set.name = json.at("name");
  read_counts(json, {{"paths", set.paths},
                     {"poses", set.poses},
                     {"meets", set.meets},
                     {"open", set.open},
                     {"unseen", set.unseen}});
  return set;
}

PathCell path_cell_of(const Json& json) {
  PathCell cell;
  if (json.contains("first_pose"))
    read_counts(json.at("first_pose"), {{"right", cell.pose_right},
                                        {"later", cell.pose_later},
                                        {"earlier", cell.pose_earlier},
                                        {"open", cell.pose_open}});
  if (json.contains("gap")) {
    cell.gap = json.at("gap");
    return cell;
  }
  cell.check = json.at("check");
  const Json& impacts = json.at("impacts");
  read_counts(impacts, {{"answered", cell.answered},
                        {"missed", cell.missed},
                        {"late", cell.late},
                        {"phantom", cell.phantom},
                        {"open", cell.open},
                        {"failed", cell.failed},
                        {"unsupported", cell.unsupported}});
  if (cell.answered > 0) cell.worst = path_of(json.at("worst"));
  // Files of before early stops were counted name the dearest answer, so that one is known.
  cell.early = impacts.value("early", std::size_t{is_early(cell.worst) ? 1u : 0u});
  for (const Json& each : json.at("wrong_cases")) cell.wrong_cases.push_back(path_of(each));
  return cell;
}

}  // namespace touchstone::comparison
