#include <algorithm>
#include <chrono>
#include <cmath>

#include "touchstone/contact_core/broadphase/register_broadphases.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/world/scene_world.hpp"
#include "touchstone/examples/fit/serves.hpp"

namespace touchstone::fitting {
namespace {

using Clock = std::chrono::steady_clock;

std::size_t index_of(const Scene& scene, const ServedMesh& mesh) {
  const std::size_t target = find_object(scene, mesh.object);
  if (target == kNoObject)
    reject("--serves",
           "scene '" + scene.name + "' has no object '" + mesh.object + "', as the mesh is named");
  const SceneObject& object = scene.objects[target];
  if (!object.motion.at_rest() || carrier_of(scene, target) != kNoObject || may_be_taken_along(scene, target))
    reject("--serves", "object '" + mesh.object + "' moves: one that stands can be fitted to a scene");
  return target;
}

std::vector<std::size_t> indices_of(const ServesRequest& request) {
  std::vector<std::size_t> indices;
  for (const ServedMesh& mesh : request.meshes) {
    indices.push_back(index_of(request.scene, mesh));
    if (std::find(indices.begin(), indices.end() - 1, indices.back()) != indices.end() - 1)
      reject("--serves", "object '" + mesh.object + "' has two meshes");
  }
  return indices;
}

bool moves(const Scene& scene, std::size_t object) {
  const std::size_t carrier = carrier_of(scene, object);
  if (carrier != kNoObject) return moves(scene, carrier);
  return !scene.objects[object].motion.at_rest() || may_be_taken_along(scene, object);
}

std::vector<std::size_t> movers_of(const Scene& scene) {
  std::vector<std::size_t> movers;
  for (std::size_t i = 0; i < scene.objects.size(); ++i)
    if (moves(scene, i)) movers.push_back(i);
  if (movers.empty()) reject("--serves", "nothing moves in scene '" + scene.name + "'");
  return movers;
}

/// How far a point of the object moves at most from one pose to the next.
double step_length(const Pose& from, const Pose& to, double radius) {
  const Matrix3 turn = to.R * from.R.transpose();
  const double cosine = std::clamp(0.5 * (turn.trace() - 1.0), -1.0, 1.0);
  return norm(to.p - from.p) + radius * std::acos(cosine);
}

/// A mover's boxes in a mesh's frame, one a frame: of its vertices at the ends of each part of the frame, as
/// far as the arc between them can bulge; in a part it turns by less than a right angle.
class Sweep {
 public:
  Sweep(const HexahedronTree& tree, const Pose& X_WT) : X_TW_(inverse(X_WT)) {
    for (const PlacedHexahedron& each : tree.solids()) {
      for (const Vector3& v : each.solid.vertices()) {
        points_O_.push_back(transform(each.X_OS, v));
        reach_ = std::max(reach_, norm(points_O_.back()) + each.solid.radius());
      }
      around_ = std::max(around_, each.solid.radius());
    }
  }

  /// The first pose of all, or the next end of a part.
  void add(const Pose& X_WO) {
    Bounds now;
    for (const Vector3& p_O : points_O_) now.add(transform(X_TW_, transform(X_WO, p_O)));
    if (has_last_) {
      const double more = around_ + 0.5 * step_length(last_pose_, X_WO, reach_);
      Bounds both = now;
      both.add(last_.low), both.add(last_.high);
      frame_.add(both.low - Vector3::Constant(more)), frame_.add(both.high + Vector3::Constant(more));
    }
    last_ = now;
    last_pose_ = X_WO;
    has_last_ = true;
  }
  void end_frame() {
    boxes_.push_back(frame_);
    frame_ = {};
  }

  const std::vector<Bounds>& boxes() const { return boxes_; }

 private:
  Pose X_TW_, last_pose_;
  std::vector<Vector3> points_O_;
  double reach_ = 0.0, around_ = 0.0;
  bool has_last_ = false;
  Bounds last_, frame_;
  std::vector<Bounds> boxes_;
};

Scene with_covers(const ServesRequest& request, std::span<const Fit* const> covers,
                  const std::vector<std::size_t>& targets) {
  Scene scene = request.scene;
  for (std::size_t m = 0; m < targets.size(); ++m) {
    SceneObject& object = scene.objects[targets[m]];
    object.tree = make_tree(*covers[m], request.meshes[m].object);
    object.levels.clear();  // they hold the scene's hexahedra, not the cover's
  }
  return scene;
}

/// Near events then carry clearances up to the margin; all else of the pairs' rules stays.
void warn_within(double margin, const std::vector<std::size_t>& targets,
                 const std::vector<std::size_t>& movers, SceneWorld& flown) {
  ContactWorld& world = flown.world();
  for (const std::size_t target : targets) {
    for (const std::size_t mover : movers) {
      const ObjectHandle a = flown.object(target), b = flown.object(mover);
      const EffectiveRule rule = world.rule_of(a, b);
      world.set_pair_rule(
          a, b, {rule.policy, std::max(rule.warn_distance, margin), rule.translation_only, rule.passive});
    }
  }
}

/// Adds the frame that was flown last to the movers' sweeps.
void follow(SceneWorld& flown, const std::vector<std::size_t>& movers,
            std::vector<std::vector<Sweep>>& sweeps) {
  const ContactWorld& world = flown.world();
  for (std::size_t i = 0; i < movers.size(); ++i) {
    const ObjectHandle object = flown.object(movers[i]);
    for (std::vector<Sweep>& each : sweeps) {
      // Slides may go around a corner: each sub-step is a part.
      for (std::size_t part = 0; part < world.executed_parts(); ++part) {
        each[i].add(world.executed_pose(object, part, 0.0));
        each[i].add(world.executed_pose(object, part, 1.0));
      }
      each[i].add(world.actual_pose(object));
      each[i].end_frame();
    }
  }
}

}  // namespace

void validate(const ServesRequest& request) {
  static_cast<void>(indices_of(request));
  static_cast<void>(movers_of(request.scene));
}

ServedFlight fly_scene(const ServesRequest& request, std::span<const Fit* const> covers) {
  // The scene, its meshes replaced by their covers.
  const std::vector<std::size_t> targets = indices_of(request), movers = movers_of(request.scene);
  const Scene scene = with_covers(request, covers, targets);
  SceneWorld flown(scene, make_native(), make_native_broadphase());
  warn_within(request.margin, targets, movers, flown);
  const ContactWorld& world = flown.world();
  ServedFlight flight;
  flight.least_clearance = kInfinity;
  // Movers are followed in each mesh's frame.
  std::vector<std::vector<Sweep>> sweeps(targets.size());
  for (std::size_t m = 0; m < targets.size(); ++m)
    for (const std::size_t mover : movers)
      sweeps[m].emplace_back(scene.objects[mover].tree, scene.objects[targets[m]].X_WO);
  const auto look = [&] {
    for (const std::size_t mover : movers) flight.places.push_back(world.actual_pose(flown.object(mover)).p);
  };
  const auto is_about_mesh = [&](const ContactEvent& event) {
    return std::any_of(targets.begin(), targets.end(), [&](std::size_t target) {
      return event.a == flown.object(target) || event.b == flown.object(target);
    });
  };
  // The scene is flown frame by frame.
  std::vector<double> times;
  look();
  for (std::vector<Sweep>& each : sweeps)
    for (std::size_t i = 0; i < movers.size(); ++i) each[i].add(world.actual_pose(flown.object(movers[i])));
  for (std::uint64_t k = 0; k + 1 < scene.frame_count(); ++k) {
    const Clock::time_point start = Clock::now();
    const FrameReport report = flown.step();
    times.push_back(std::chrono::duration<double, std::micro>(Clock::now() - start).count());
    for (const ContactEvent& event : report.events) {
      if (!is_about_mesh(event)) continue;
      if (event.kind == EventKind::began && !flight.first_contact)
        flight.first_contact = flown.time_of(event.s);
      flight.least_clearance = std::min(flight.least_clearance, event.geometry.separation);
    }
    look();
    follow(flown, movers, sweeps);
  }
  // Where movers went, and what frames took.
  for (std::vector<Sweep>& each : sweeps) {
    std::vector<Bounds>& all = flight.swept.emplace_back();
    for (const Sweep& sweep : each) all.insert(all.end(), sweep.boxes().begin(), sweep.boxes().end());
  }
  if (!times.empty()) {
    std::sort(times.begin(), times.end());
    flight.frame_us = times[times.size() / 2];
    flight.slowest_us = times.back();
  }
  return flight;
}

}  // namespace touchstone::fitting
