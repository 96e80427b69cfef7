#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>

#include "touchstone/adapters/c_interface/calls.hpp"
#include "touchstone/adapters/c_interface/corners.hpp"
#include "touchstone/adapters/c_interface/layout.hpp"
#include "touchstone/adapters/c_interface/touchstone.h"
#ifdef TOUCHSTONE_HAS_EXACT
#include "touchstone/adapters/exact/exact.hpp"
#endif

using namespace touchstone;
using c_interface::guarded;
using c_interface::registry;
using c_interface::require;

namespace touchstone::c_interface {
namespace {

/// A line of fixed size, so that a failure for want of memory can be reported.
thread_local char error_text[512] = "";

}  // namespace

touchstone_code fail(touchstone_code code, const char* text) noexcept {
  std::snprintf(error_text, sizeof error_text, "%s", text);
  return code;
}

const BackendRegistry& registry() {
  static const BackendRegistry filled = [] {
    BackendRegistry backends;
    register_core(backends);
#ifdef TOUCHSTONE_HAS_EXACT
    register_exact(backends);
#endif
    return backends;
  }();
  return filled;
}

}  // namespace touchstone::c_interface

struct touchstone_narrowphase {
  std::unique_ptr<Narrowphase> narrowphase;
  std::size_t solids = 0;
};

struct touchstone_workspace {
  const touchstone_narrowphase* of = nullptr;
  std::unique_ptr<Narrowphase::Workspace> workspace;
};

namespace {

void check_query(const touchstone_query& query) {
  if (query.kind < TOUCHSTONE_OVERLAP || query.kind > TOUCHSTONE_MANIFOLD)
    reject("query", "kind " + std::to_string(query.kind) + " is none");
  if (query.kind == TOUCHSTONE_MANIFOLD && (query.max_points < 1 || query.max_points > TOUCHSTONE_MAX_POINTS))
    reject("query", "max_points is " + std::to_string(query.max_points) + ", must be 1 to " +
                        std::to_string(TOUCHSTONE_MAX_POINTS));
  if (!(query.max_separation >= 0.0))
    reject("query", "max_separation is " + figure(query.max_separation) + ", must be >= 0");
  if (std::isnan(query.max_point_separation)) reject("query", "max_point_separation is nan");
}

void check_pairs(const touchstone_input& input, std::size_t solids) {
  const auto is_good = [solids](const touchstone_pair& pair) {
    return pair.a != pair.b && pair.a < solids && pair.b < solids;
  };
  std::size_t i = 0;
  while (i < input.pair_count && is_good(input.pairs[i])) ++i;
  if (i == input.pair_count) return;
  const auto [a, b] = input.pairs[i];
  reject("pair " + std::to_string(i), "(" + std::to_string(a) + ", " + std::to_string(b) +
                                          ") is not two of the " + std::to_string(solids) + " solids");
}

void check_call(const touchstone_narrowphase* narrowphase, const touchstone_workspace* workspace,
                const touchstone_input* input, const touchstone_output* output) {
  require(narrowphase, "narrowphase");
  require(workspace, "workspace");
  require(input, "input");
  require(output, "output");
  if (workspace->of != narrowphase) reject("workspace", "was made for another narrowphase");
  check_query(input->query);
  if (input->pose_count < narrowphase->solids)
    reject("poses", "has " + std::to_string(input->pose_count) + " entries, needs " +
                        std::to_string(narrowphase->solids) + ", one a solid");
  if (input->pair_count == 0) return;
  require(input->pairs, "pairs");
  require(input->poses, "poses");
  require(output->status, "status");
  if (input->query.kind >= TOUCHSTONE_DISTANCE) require(output->geometry, "geometry");
  if (input->query.kind == TOUCHSTONE_MANIFOLD) require(output->points, "points");
  check_pairs(*input, narrowphase->solids);
}

NarrowphaseInput input_of(const touchstone_input& input) {
  Query query;
  query.kind = static_cast<QueryKind>(input.query.kind);
  query.max_separation = input.query.max_separation;
  query.max_point_separation = input.query.max_point_separation;
  if (query.kind == QueryKind::manifold) query.max_points = input.query.max_points;
  return {{reinterpret_cast<const SolidPair*>(input.pairs), input.pair_count},
          {reinterpret_cast<const Pose*>(input.poses), input.pose_count},
          query,
          {}};
}

NarrowphaseOutput output_of(const touchstone_output& output, const touchstone_input& input) {
  const auto slots = static_cast<std::size_t>(std::max(input.query.max_points, 0));
  NarrowphaseOutput of{{reinterpret_cast<PairStatus*>(output.status), input.pair_count}, {}, {}};
  if (output.geometry != nullptr)
    of.geometry = {reinterpret_cast<PairGeometry*>(output.geometry), input.pair_count};
  if (output.points != nullptr && input.query.kind == TOUCHSTONE_MANIFOLD)
    of.points = {reinterpret_cast<ContactPoint*>(output.points), input.pair_count * slots};
  return of;
}

}  // namespace

uint32_t touchstone_abi_version(void) { return TOUCHSTONE_ABI_VERSION; }
const char* touchstone_version(void) { return TOUCHSTONE_VERSION; }
const char* touchstone_error(void) { return touchstone::c_interface::error_text; }

size_t touchstone_backend_count(void) {
  size_t count = 0;
  guarded({}, [&] { count = registry().narrowphases().size(); });
  return count;
}

const char* touchstone_backend_name(size_t index) {
  const char* name = nullptr;
  guarded({}, [&] {
    if (index < registry().narrowphases().size()) name = registry().narrowphases()[index].name.c_str();
  });
  return name;
}

touchstone_code touchstone_create(const char* backend, touchstone_narrowphase** out) {
  return guarded({{backend, "backend"}, {static_cast<const void*>(out), "out"}}, [&] {
    auto made = std::make_unique<touchstone_narrowphase>();
    made->narrowphase = registry().make_narrowphase(backend);
    *out = made.release();
  });
}

void touchstone_destroy(touchstone_narrowphase* narrowphase) { delete narrowphase; }

touchstone_code touchstone_get_capabilities(const touchstone_narrowphase* narrowphase,
                                            touchstone_capabilities* out) {
  return guarded({{narrowphase, "narrowphase"}, {out, "out"}},
                 [&] { *out = c_interface::c_capabilities(narrowphase->narrowphase->capabilities()); });
}

touchstone_code touchstone_build(touchstone_narrowphase* narrowphase, const double* corners, size_t solids) {
  return touchstone_build_rounded(narrowphase, corners, nullptr, solids);
}

touchstone_code touchstone_build_rounded(touchstone_narrowphase* narrowphase, const double* corners,
                                         const double* radii, size_t solids) {
  return guarded({{narrowphase, "narrowphase"}}, [&] {
    if (solids > 0) require(corners, "corners");
    const auto made = c_interface::solids_from_corners({corners, solids * c_interface::kCornerDoubles},
                                                       {radii, radii == nullptr ? 0 : solids});
    narrowphase->narrowphase->build(made);
    narrowphase->solids = solids;
  });
}

touchstone_code touchstone_create_workspace(const touchstone_narrowphase* narrowphase,
                                            touchstone_workspace** out) {
  return guarded({{narrowphase, "narrowphase"}, {static_cast<const void*>(out), "out"}}, [&] {
    auto made = std::make_unique<touchstone_workspace>();
    made->of = narrowphase;
    made->workspace = narrowphase->narrowphase->make_workspace();
    *out = made.release();
  });
}

void touchstone_destroy_workspace(touchstone_workspace* workspace) { delete workspace; }

touchstone_code touchstone_evaluate(const touchstone_narrowphase* narrowphase,
                                    touchstone_workspace* workspace, const touchstone_input* input,
                                    const touchstone_output* output) {
  return guarded({}, [&] {
    check_call(narrowphase, workspace, input, output);
    if (input->pair_count == 0) return;
    narrowphase->narrowphase->evaluate(input_of(*input), output_of(*output, *input), *workspace->workspace);
  });
}

touchstone_code touchstone_pose_from_matrix(const double matrix[16], touchstone_pose* out) {
  return guarded({{matrix, "matrix"}, {out, "out"}}, [&] {
    Matrix4 X;
    for (int row = 0; row < 4; ++row)
      for (int column = 0; column < 4; ++column) X(row, column) = matrix[4 * row + column];
    reinterpret_cast<Pose&>(*out) = pose_from_matrix(X);
  });
}

touchstone_code touchstone_pose_from_quaternion(const double position[3], const double quaternion[4],
                                                touchstone_pose* out) {
  return guarded({{position, "position"}, {quaternion, "quaternion"}, {out, "out"}}, [&] {
    const Vector3 p(position[0], position[1], position[2]);
    if (!is_finite(p)) reject("position", "is not finite");
    const Matrix3 R = rotation_from_quaternion(quaternion[0], quaternion[1], quaternion[2], quaternion[3]);
    reinterpret_cast<Pose&>(*out) = {R, p};
  });
}
