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
  path.cost = read_cost(json, "cost_m");
  path.cost_over_scale = read_cost(json, "cost_over_S");
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
  check_parts({set.meets, set.open}, set.paths, "more paths meet or are open than there are 'paths'");
  check_parts({set.unseen}, set.meets, "more are 'unseen' than meet");
  return set;
}

PathCell path_cell_of(const Json& json, std::size_t paths) {
  PathCell cell;
  // At the poses.
  if (json.contains("first_pose"))
    read_counts(json.at("first_pose"), {{"right", cell.pose_right},
                                        {"later", cell.pose_later},
                                        {"earlier", cell.pose_earlier},
                                        {"open", cell.pose_open}});
  check_parts({cell.pose_right, cell.pose_later, cell.pose_earlier, cell.pose_open}, paths,
              "'first_pose' counts more than there are paths");
  if (json.contains("gap")) {
    cell.gap = json.at("gap");
    return cell;
  }

  // Times of impact. Files of before early stops were counted name the dearest answer, so that one is known.
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
  if (impacts.contains("early"))
    read_counts(impacts, {{"early", cell.early}});
  else
    cell.early = is_early(cell.worst) ? 1 : 0;
  check_parts({cell.answered, cell.unsupported}, paths, "'impacts' counts more than there are paths");
  check_parts({cell.missed, cell.late, cell.phantom, cell.early, cell.open, cell.failed}, cell.answered,
              "there are more wrong and open impacts than 'answered'");
  for (const Json& each : json.at("wrong_cases")) cell.wrong_cases.push_back(path_of(each));
  return cell;
}

}  // namespace touchstone::comparison
