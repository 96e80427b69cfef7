#include "touchstone/examples/fit/serves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "touchstone/contact_core/broadphase/register_broadphases.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/world/scene_world.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::fitting {
namespace {

constexpr double kCoarsest = 64.0, kFinest = 4.0;  // times the tolerance, elsewhere
constexpr int kMostZones = 4;                      // each from a flight that left the one before

using Clock = std::chrono::steady_clock;

std::size_t target_of(const ServesRequest& request) {
  const Scene& scene = request.scene;
  const std::size_t target = find_object(scene, request.object);
  if (target == kNoObject)
    reject("--serves",
           "scene '" + scene.name + "' has no object '" + request.object + "', as the mesh is named");
  const SceneObject& object = scene.objects[target];
  if (!object.motion.at_rest() || carrier_of(scene, target) != kNoObject)
    reject("--serves", "object '" + request.object + "' moves: one that stands can be fitted to a scene");
  return target;
}

bool moves(const Scene& scene, std::size_t object) {
  const std::size_t carrier = carrier_of(scene, object);
  if (carrier != kNoObject) return moves(scene, carrier);
  return !scene.objects[object].motion.at_rest();
}

Scene with_cover(const ServesRequest& request, const Fit& fit) {
  Scene scene = request.scene;
  scene.objects[target_of(request)].tree = make_tree(fit, request.object);
  return scene;
}

/// How far a point of the object moves at most from one pose to the next.
double step_length(const Pose& from, const Pose& to, double radius) {
  const Matrix3 turn = to.R * from.R.transpose();
  const double cosine = std::clamp(0.5 * (turn.trace() - 1.0), -1.0, 1.0);
  return norm(to.p - from.p) + radius * std::acos(cosine);
}

/// Of the vertices in the target's frame, as far as the arc between two frames can bulge.
class Sweep {
 public:
  Sweep(const Scene& scene, std::size_t target) : scene_(scene), X_TW_(inverse(scene.objects[target].X_WO)) {
    for (std::size_t i = 0; i < scene.objects.size(); ++i)
      if (i != target && moves(scene, i)) movers_.push_back({i, scene.objects[i].X_WO});
    if (movers_.empty()) reject("--serves", "nothing moves in scene '" + scene.name + "'");
  }

  void add(SceneWorld& world) {
    for (Mover& mover : movers_) {
      const Pose X_WO = world.world().actual_pose(world.object(mover.object));
      const HexahedronTree& tree = scene_.objects[mover.object].tree;
      double radius = 0.0;
      for (const PlacedHexahedron& each : tree.solids())
        for (const Vector3& v : each.solid.vertices()) {
          const Vector3 p_O = transform(each.X_OS, v);
          radius = std::max(radius, norm(p_O) + each.solid.radius());
          const Vector3 p_T = transform(X_TW_, transform(X_WO, p_O));
          const Vector3 around = Vector3::Constant(each.solid.radius());
          bounds_.add(p_T - around), bounds_.add(p_T + around);
        }
      bulge_ = std::max(bulge_, 0.5 * step_length(mover.X_WO, X_WO, radius));
      mover.X_WO = X_WO;
    }
  }
  Bounds bounds() const {
    return {bounds_.low - Vector3::Constant(bulge_), bounds_.high + Vector3::Constant(bulge_)};
  }

 private:
  struct Mover {
    std::size_t object;
    Pose X_WO;
  };
  const Scene& scene_;
  Pose X_TW_;
  std::vector<Mover> movers_;
  Bounds bounds_;
  double bulge_ = 0.0;
};

bool is_about(const ContactEvent& event, ObjectHandle object) {
  return event.a == object || event.b == object;
}

Bounds inflated(const Bounds& box, double by) {
  return {box.low - Vector3::Constant(by), box.high + Vector3::Constant(by)};
}

bool holds(const Bounds& outer, const Bounds& inner) {
  return (inner.low - outer.low).minCoeff() >= 0.0 && (outer.high - inner.high).minCoeff() >= 0.0;
}

/// Corners in the units of the file, as a region of the command line has them.
RegionRequest region_of(const Bounds& zone, double tolerance, double scale) {
  return {"zone", {tolerance, false}, zone.low / scale, zone.high / scale};
}

}  // namespace

ServedFlight fly_scene(const ServesRequest& request, const Fit& fit) {
  Scene scene = with_cover(request, fit);
  const std::size_t target = target_of(request);
  // Near events carry clearances up to the margin, for what the object meets.
  for (std::size_t i = 0; i < scene.objects.size(); ++i)
    if (i != target && moves(scene, i))
      scene.rules.push_back({request.object, scene.objects[i].tree.name(), {}, request.margin, {}, {}});
  SceneWorld world(scene, make_native(), make_native_broadphase());
  ServedFlight flight;
  flight.least_clearance = kInfinity;
  Sweep sweep(scene, target);
  sweep.add(world);
  std::vector<double> times;
  for (std::uint64_t k = 0; k + 1 < scene.frame_count(); ++k) {
    const Clock::time_point start = Clock::now();
    const FrameReport report = world.step();
    times.push_back(std::chrono::duration<double, std::micro>(Clock::now() - start).count());
    for (const ContactEvent& event : report.events) {
      if (!is_about(event, world.object(target))) continue;
      if (event.kind == EventKind::began && !flight.first_contact)
        flight.first_contact = world.time_of(event.s);
      flight.least_clearance = std::min(flight.least_clearance, event.geometry.separation);
    }
    sweep.add(world);
  }
  flight.swept = sweep.bounds();
  if (!times.empty()) {
    std::sort(times.begin(), times.end());
    flight.frame_us = times[times.size() / 2];
    flight.slowest_us = times.back();
  }
  return flight;
}

ServesResult find_coarsest(const std::filesystem::path& mesh, const FitRequest& fit,
                           const ServesRequest& request, comparison::ProgressLine& progress) {
  target_of(request);
  ServesResult result;
  FitRequest coarse = fit;
  coarse.page = false;
  coarse.over = {kCoarsest * request.tolerance, false};
  const double diagonal = MeshDistance(weld(read_mesh(mesh, fit.input).mesh)).bounds().diagonal();
  coarse.over.value = std::min(coarse.over.value, 0.25 * diagonal);
  progress.step("a first flight");
  const FitRun first = run_fit(mesh, coarse, progress);
  result.zone = inflated(fly_scene(request, first.fit).swept, 2.0 * request.margin + first.fit.excess);

  const auto row_with = [&](double elsewhere, bool is_uniform) {
    ServesRow row;
    row.elsewhere = elsewhere;
    FitRequest asked = coarse;
    asked.over = {elsewhere, false};
    if (!is_uniform)
      asked.regions.push_back(region_of(result.zone, request.tolerance, first.certificate.scale));
    row.run = run_fit(mesh, asked, progress);
    row.in_zone = is_uniform ? row.run.fit.excess : row.run.fit.region_excess.back();
    row.flight = fly_scene(request, row.run.fit);
    row.serves = row.run.verdict.is_proven && row.in_zone <= request.tolerance &&
                 (is_uniform || holds(result.zone, inflated(row.flight.swept, request.margin)));
    return row;
  };
  // A finer cover lets what moves get farther: then the zone grows, and all is fitted anew.
  for (int zones = 0, grown = 1; grown != 0 && zones < kMostZones; ++zones) {
    grown = 0;
    result.rows.clear();
    for (double times = kCoarsest; times >= kFinest && grown == 0; times /= 2.0) {
      const double elsewhere = times * request.tolerance;
      if (elsewhere > 0.25 * diagonal && times > kFinest) continue;
      progress.step(fmt::format("{:.4g} mm elsewhere", 1e3 * elsewhere));
      result.rows.push_back(row_with(elsewhere, false));
      Bounds wanted = inflated(result.rows.back().flight.swept, request.margin);
      if (holds(result.zone, wanted)) continue;
      wanted.add(result.zone.low), wanted.add(result.zone.high);
      result.zone = inflated(wanted, request.margin);
      grown = 1;
    }
  }
  if (request.with_uniform) {
    progress.step("the tolerance everywhere");
    result.rows.push_back(row_with(request.tolerance, true));
  }
  for (std::size_t i = 0; i < result.rows.size(); ++i) {
    const ServesRow& row = result.rows[i];
    if (row.serves && (!result.coarsest ||
                       row.run.fit.hexahedra.size() < result.rows[*result.coarsest].run.fit.hexahedra.size()))
      result.coarsest = i;
  }
  return result;
}

std::string serves_text(const ServesResult& result, const ServesRequest& request) {
  comparison::TextTable table({"elsewhere [mm]", "hexahedra", "error in zone [mm]", "proof",
                               "first contact [s]", "least clearance [mm]", "frame [us]", "worst", "serves"});
  // Covers that do not serve are shown, too.
  for (const ServesRow& row : result.rows)
    table.add({fmt::format("{:.4g}", 1e3 * row.elsewhere), std::to_string(row.run.fit.hexahedra.size()),
               fmt::format("{:.4g}", 1e3 * row.in_zone), row.run.verdict.is_proven ? "proven" : "REFUSED",
               row.flight.first_contact ? fmt::format("{:.6f}", *row.flight.first_contact) : "-",
               std::isfinite(row.flight.least_clearance)
                   ? fmt::format("{:.4g}", 1e3 * row.flight.least_clearance)
                   : "> margin",
               fmt::format("{:.1f}", row.flight.frame_us), fmt::format("{:.0f}", row.flight.slowest_us),
               row.serves ? "yes" : "no"});
  const auto corner = [](const Vector3& p) {
    return fmt::format("({:.4g}, {:.4g}, {:.4g})", p.x(), p.y(), p.z());
  };
  // Figures hold within the zone, which the text names.
  std::string text = fmt::format(
      "{}\nzone {} to {} m in '{}': what moves in scene '{}', {:.4g} mm about it; clearances up to that, "
      "stops and "
      "first contacts are the mesh's to the error in the zone\n",
      table.str(), corner(result.zone.low), corner(result.zone.high), request.object, request.scene.name,
      1e3 * request.margin);
  // The search may end without a cover.
  if (!result.coarsest) return text + "no cover within the tolerance was found\n";
  return text + fmt::format("coarsest that serves: {} hexahedra, {:.4g} mm elsewhere\n",
                            result.rows[*result.coarsest].run.fit.hexahedra.size(),
                            1e3 * result.rows[*result.coarsest].elsewhere);
}

}  // namespace touchstone::fitting
