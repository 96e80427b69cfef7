#include "touchstone/examples/bench/site/path_cell.hpp"

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

}  // namespace

FiledPathSet path_set_of(const Json& json) {
  return {json.at("name"),  json.at("paths"), json.at("poses"),
          json.at("meets"), json.at("open"),  json.at("unseen")};
}

PathCell path_cell_of(const Json& json) {
  PathCell cell;
  const Json& pose = json.at("first_pose");
  cell.pose_right = pose.at("right");
  cell.pose_later = pose.at("later");
  cell.pose_earlier = pose.at("earlier");
  cell.pose_open = pose.at("open");
  if (json.contains("gap")) {
    cell.gap = json.at("gap");
    return cell;
  }
  cell.check = json.at("check");
  const Json& impacts = json.at("impacts");
  cell.answered = impacts.at("answered");
  cell.missed = impacts.at("missed");
  cell.late = impacts.at("late");
  cell.phantom = impacts.at("phantom");
  cell.open = impacts.at("open");
  cell.failed = impacts.at("failed");
  cell.unsupported = impacts.at("unsupported");
  if (cell.answered > 0) cell.worst = path_of(json.at("worst"));
  for (const Json& each : json.at("wrong_cases")) cell.wrong_cases.push_back(path_of(each));
  return cell;
}

}  // namespace touchstone::comparison
