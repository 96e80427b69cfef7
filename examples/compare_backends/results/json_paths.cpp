#include "touchstone/examples/compare_backends/results/json_parts.hpp"

namespace touchstone::comparison {
namespace {

using comparison::json;

Json json(const PathFault& fault) {
  return {{"path", fault.id},
          {"reason", fault.reason},
          {"stops_at_s", number(fault.s)},
          {"cost_m", number(fault.cost)},
          {"cost_over_S", number(fault.cost_over_scale)}};
}

Json json(const PathBackendResult& backend) {
  Json result = {{"backend", backend.name}};
  if (!backend.sweep.empty())
    result["sweep"] = backend.sweep;
  else
    result["first_pose"] = {{"right", backend.pose_right},
                            {"later", backend.pose_later},
                            {"earlier", backend.pose_earlier},
                            {"open", backend.pose_open}};
  if (!backend.why_none.empty()) {
    result["gap"] = backend.why_none;
    return result;
  }
  result["check"] = backend.check;
  result["impacts"] = {{"answered", backend.answered}, {"missed", backend.missed},
                       {"late", backend.late},         {"phantom", backend.phantom},
                       {"early", backend.early},       {"open", backend.open},
                       {"failed", backend.failed},     {"unsupported", backend.unsupported}};
  if (backend.answered > 0) result["worst"] = json(backend.worst);
  result["wrong_cases"] = Json::array();
  for (const PathFault& fault : backend.faults) result["wrong_cases"].push_back(json(fault));
  return result;
}

}  // namespace

Json json(const PathSetResult& set) {
  Json result = {{"name", set.name}, {"paths", set.paths},   {"poses", set.poses},       {"meets", set.meets},
                 {"open", set.open}, {"unseen", set.unseen}, {"backends", Json::array()}};
  for (const PathBackendResult& backend : set.backends) result["backends"].push_back(json(backend));
  return result;
}

}  // namespace touchstone::comparison
