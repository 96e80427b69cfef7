#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "touchstone/contact_core/broadphase/register_broadphases.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/threads/processor_time.hpp"
#include "touchstone/contact_core/world/scene_world.hpp"
#include "touchstone/examples/fit/serves.hpp"
#include "touchstone/examples/fit/surface_tree.hpp"

namespace touchstone::fitting {
namespace {

constexpr int kFlights = 3;        // of which each frame's time is the least
constexpr double kSkin = 0x1p-10;  // of the tolerance: how thick a mesh's triangles are flown

std::size_t index_of(const Scene& scene, const ServedMesh& mesh) {
  const std::size_t target = find_object(scene, mesh.object);
  if (target == kNoObject)
    reject("--serves",
           "scene '" + scene.name + "' has no object '" + mesh.object + "', as the mesh is named");
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

/// Its carrier, and the carrier's own.
std::size_t root_of(const Scene& scene, std::size_t object) {
  const std::size_t carrier = carrier_of(scene, object);
  return carrier == kNoObject ? object : root_of(scene, carrier);
}

/// Whether one of the exempt pairs is these two as a whole.
bool are_exempt(const Scene& scene, std::span<const ExemptPair> pairs, std::size_t a, std::size_t b) {
  const auto has = [&](const std::string& name, std::size_t object) {
    const std::vector<std::size_t> found = find_objects(scene, name);
    return std::find(found.begin(), found.end(), object) != found.end();
  };
  return std::any_of(pairs.begin(), pairs.end(), [&](const ExemptPair& pair) {
    return (has(pair.first, a) && has(pair.second, b)) || (has(pair.first, b) && has(pair.second, a));
  });
}

/// Whether the world checks them against each other, and one of them moves.
bool may_meet(const Scene& scene, std::size_t a, std::size_t b) {
  if (a == b || !(moves(scene, a) || moves(scene, b)) || root_of(scene, a) == root_of(scene, b)) return false;
  return !are_exempt(scene, scene.exempt_pairs, a, b) &&
         std::none_of(scene.latches.begin(), scene.latches.end(),
                      [&](const SceneLatch& latch) { return are_exempt(scene, latch.allowed, a, b); });
}

std::vector<std::size_t> those_that_may_meet(const Scene& scene, std::size_t target) {
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i < scene.objects.size(); ++i)
    if (may_meet(scene, target, i)) others.push_back(i);
  return others;
}

double angle_between(const Matrix3& from, const Matrix3& to) {
  // Frobenius' norm of the difference is sqrt(8) sin(angle / 2).
  return 2.0 * std::asin(std::min(1.0, std::sqrt((to - from).squaredNorm() / 8.0)));
}

/// A mesh and another object at one time.
struct Places {
  Pose X_WT, X_WO;
};

/// How far an arc leaves its chord, most in the middle, for less than a turn: of a point that goes on
/// straight and about an axis, both evenly, as origins do between two poses.
double bow(const Vector3& start_W, const Vector3& middle_W, const Vector3& end_W) {
  return norm(middle_W - 0.5 * (start_W + end_W));
}

/// Follows what a mesh sees of another object, both on paths of a straight line and less than a turn.
class Follower {
 public:
  Follower(std::size_t object, std::optional<std::size_t> mesh, const HexahedronTree& tree) {
    seen_.object = object;
    seen_.mesh = mesh;
    seen_.parts_O = part_boxes(tree);
    for (const Bounds& part : seen_.parts_O)
      reach_ = std::max(reach_, norm(Vector3(part.low.cwiseAbs().cwiseMax(part.high.cwiseAbs()))));
  }

  /// The first places of all, or where the last ones went straight.
  void add(const Places& end) {
    add({{end.X_WT.R, 0.5 * (last_.X_WT.p + end.X_WT.p)}, {end.X_WO.R, 0.5 * (last_.X_WO.p + end.X_WO.p)}},
        end);
  }
  /// The next ones, and those in the middle of the way to them.
  void add(const Places& middle, const Places& end) {
    const double strays = seen_.X_TO.empty() ? 0.0 : most_off(middle, end);
    const Pose X_TO = compose(inverse(end.X_WT), end.X_WO);
    last_ = end;
    if (!seen_.X_TO.empty() && strays == 0.0 && is_same(X_TO, seen_.X_TO.back())) return;
    seen_.X_TO.push_back(X_TO);
    seen_.strays.push_back(strays);
  }

  SeenObject take() { return std::move(seen_); }

 private:
  /// Were both origins on their chords, a point would be no farther from one of both ends than half of its
  /// way, which is no longer than that of the chords' difference, and of the turns: seen from a mesh that
  /// turns, all goes about its origin. What the arcs add is how far they leave the chords.
  double most_off(const Places& middle, const Places& end) const {
    const auto turned = [](const Pose& from, const Pose& by, const Pose& to) {
      return angle_between(from.R, by.R) + angle_between(by.R, to.R);
    };
    const double turned_T = turned(last_.X_WT, middle.X_WT, end.X_WT),
                 turned_O = turned(last_.X_WO, middle.X_WO, end.X_WO);
    const Vector3 from = last_.X_WO.p - last_.X_WT.p, to = end.X_WO.p - end.X_WT.p;
    const double way =
        norm(to - from) + turned_T * std::max(norm(from), norm(to)) + reach_ * (turned_T + turned_O);
    return 0.5 * way + bow(last_.X_WT.p, middle.X_WT.p, end.X_WT.p) +
           bow(last_.X_WO.p, middle.X_WO.p, end.X_WO.p);
  }

  SeenObject seen_;
  Places last_;
  double reach_ = 0.0;
};

std::vector<HexahedronTree> trees_of(const ServesRequest& request, std::span<const Fit* const> covers) {
  std::vector<HexahedronTree> trees;
  for (std::size_t m = 0; m < covers.size(); ++m)
    trees.push_back(make_tree(*covers[m], request.meshes[m].object));
  return trees;
}

Scene with_trees(const ServesRequest& request, std::vector<HexahedronTree> trees,
                 const std::vector<std::size_t>& targets) {
  Scene scene = request.scene;
  for (std::size_t m = 0; m < targets.size(); ++m) {
    SceneObject& object = scene.objects[targets[m]];
    object.tree = std::move(trees[m]);
    object.levels.clear();  // they hold the scene's hexahedra, not these
  }
  return scene;
}

/// Near events then carry clearances up to the margin; all else of the pairs' rules stays.
void warn_within(double margin, const std::vector<std::size_t>& targets, SceneWorld& flown) {
  ContactWorld& world = flown.world();
  for (const std::size_t target : targets) {
    for (const std::size_t other : those_that_may_meet(flown.scene(), target)) {
      const ObjectHandle a = flown.object(target), b = flown.object(other);
      const EffectiveRule rule = world.rule_of(a, b);
      world.set_pair_rule(
          a, b, {rule.policy, std::max(rule.warn_distance, margin), rule.translation_only, rule.passive});
    }
  }
}

/// From where on in a part of a frame an object stands still; 1 where it never does, or does all along.
double stop_of(const ContactWorld& world, ObjectHandle object, std::size_t part) {
  const Pose end = world.executed_pose(object, part, 1.0);
  const auto stands = [&](double s) { return is_same(world.executed_pose(object, part, s), end); };
  double moves = 0.0, stopped = std::nextafter(1.0, 0.0);
  if (stands(moves) || !stands(stopped)) return 1.0;
  // Halved until no number is between.
  for (double s = 0.5; s > moves && s < stopped; s = 0.5 * (moves + stopped))
    (stands(s) ? stopped : moves) = s;
  return stopped;
}

/// Contacts and clearances of each mesh in a flight, frame by frame.
class Followers {
 public:
  Followers(const Scene& scene, const std::vector<std::size_t>& targets) : targets_(targets) {
    for (const std::size_t target : targets) {
      std::vector<Pair>& pairs = pairs_.emplace_back();
      for (const std::size_t other : those_that_may_meet(scene, target)) {
        const auto found = std::find(targets.begin(), targets.end(), other);
        std::optional<std::size_t> mesh;
        if (found != targets.end()) mesh = static_cast<std::size_t>(found - targets.begin());
        pairs.push_back({other, Follower(other, mesh, scene.objects[other].tree)});
      }
    }
  }

  /// Adds where all are now.
  void look(SceneWorld& flown) {
    for_all(flown, [&](ObjectHandle mesh, ObjectHandle other, Follower& follower) {
      follower.add({flown.world().actual_pose(mesh), flown.world().actual_pose(other)});
    });
  }
  /// Adds the frame that was flown last. Slides may go around a corner: each sub-step is a part. Where one of
  /// both is stopped the other goes on alone.
  void follow(SceneWorld& flown) {
    const ContactWorld& world = flown.world();
    for_all(flown, [&](ObjectHandle mesh, ObjectHandle other, Follower& follower) {
      for (std::size_t part = 0; part < world.executed_parts(); ++part) {
        const auto at = [&](double s) {
          return Places{world.executed_pose(mesh, part, s), world.executed_pose(other, part, s)};
        };
        const double a = stop_of(world, mesh, part), b = stop_of(world, other, part);
        follower.add(at(0.0));
        double from = 0.0;
        for (const double to : {std::min(a, b), std::max(a, b), 1.0}) {
          if (to > from) follower.add(at(0.5 * (from + to)), at(to));
          from = to;
        }
      }
    });
    look(flown);
  }
  std::vector<std::vector<SeenObject>> take() {
    std::vector<std::vector<SeenObject>> seen;
    for (std::vector<Pair>& pairs : pairs_) {
      std::vector<SeenObject>& each = seen.emplace_back();
      for (Pair& pair : pairs) each.push_back(pair.follower.take());
    }
    return seen;
  }

 private:
  struct Pair {
    std::size_t other;
    Follower follower;
  };
  template <class Visit>
  void for_all(SceneWorld& flown, const Visit& visit) {
    for (std::size_t m = 0; m < targets_.size(); ++m)
      for (Pair& pair : pairs_[m]) visit(flown.object(targets_[m]), flown.object(pair.other), pair.follower);
  }

  const std::vector<std::size_t>& targets_;
  std::vector<std::vector<Pair>> pairs_;
};

/// A frame's times, each the least of all flights [us].
std::vector<double> frame_times(const ServesRequest& request, const Scene& scene,
                                const std::vector<std::size_t>& targets) {
  std::vector<double> least(scene.frame_count() - 1, kInfinity);
  for (int i = 0; i < kFlights; ++i) {
    SceneWorld flown(scene, make_native(), make_native_broadphase());
    warn_within(request.margin, targets, flown);
    for (double& each : least) {
      const double start = processor_us();
      static_cast<void>(flown.step());
      each = std::min(each, processor_us() - start);
    }
  }
  return least;
}

/// Tells contacts and clearances of meshes from the events of frames. However many hexahedra of two objects
/// touch, it is one contact: flush faces and slides from one to the next are none of their own.
class ContactTeller {
 public:
  explicit ContactTeller(const std::vector<std::size_t>& targets) : targets_(targets) {}

  void note(const FrameReport& report, SceneWorld& flown, ServedFlight& flight) {
    for (const ContactEvent& event : report.events) {
      // Of events with meshes, contacts and clearances count.
      const auto [a, b] = std::minmax({index_of(flown, event.a), index_of(flown, event.b)});
      if (std::none_of(targets_.begin(), targets_.end(),
                       [a = a, b = b](std::size_t t) { return t == a || t == b; }))
        continue;
      pairs_[{a, b}].add(event);
      if (event.kind == EventKind::began && !flight.first_contact)
        flight.first_contact = flown.time_of(event);
      flight.least_clearance = std::min(flight.least_clearance, event.geometry.separation);
    }
    for (auto& [pair, told] : pairs_) tell(pair, told, flown, flight);
  }

 private:
  struct Told {
    int open = 0;  ///< solids in contact
    bool was_stopped = false;
    std::optional<ContactEvent> began = {}, stopped = {}, ended = {};  ///< of the frame: first, first, last
    int more = 0;

    void add(const ContactEvent& event) {
      const auto is_first = [&](const std::optional<ContactEvent>& first) {
        return !first || std::pair(event.part, event.s) < std::pair(first->part, first->s);
      };
      if (event.kind == EventKind::began && (++more, is_first(began))) began = event;
      if (event.kind == EventKind::blocked && is_first(stopped)) stopped = event;
      if (event.kind == EventKind::ended && (--more, !is_first(ended) || !ended)) ended = event;
    }
  };
  using Pair = std::pair<std::size_t, std::size_t>;

  static std::size_t index_of(SceneWorld& flown, ObjectHandle object) {
    for (std::size_t i = 0; i < flown.scene().objects.size(); ++i)
      if (flown.object(i) == object) return i;
    return kNoObject;
  }

  static void tell(const Pair& pair, Told& told, SceneWorld& flown, ServedFlight& flight) {
    const auto say = [&](const ContactEvent& event) {
      const auto at = [&](std::size_t object) {
        return flown.world().executed_pose(flown.object(object), event.part, event.s).p;
      };
      return ToldContact{pair.first,           pair.second,    event.kind == EventKind::began,
                         flown.time_of(event), at(pair.first), at(pair.second)};
    };
    if (told.began && told.open == 0) flight.contacts.push_back(say(*told.began));
    // A slide is stopped anew at every edge that it goes over.
    const auto slides = [&] {
      return flown.world().rule_of(flown.object(pair.first), flown.object(pair.second)).policy ==
             ContactPolicy::slide;
    };
    if (told.stopped && !told.was_stopped && !slides()) flight.stops.push_back(say(*told.stopped));
    told.open += told.more;
    if (told.ended && told.open == 0) flight.contacts.push_back(say(*told.ended));
    const bool is_stopped = told.stopped.has_value();
    told = {told.open, is_stopped};
  }

  const std::vector<std::size_t>& targets_;
  std::map<Pair, Told> pairs_;
};

/// The scene flown once, frame by frame, and followed.
ServedFlight follow_flight(const ServesRequest& request, const Scene& scene,
                           const std::vector<std::size_t>& targets) {
  const std::vector<std::size_t> movers = movers_of(request.scene);
  SceneWorld flown(scene, make_native(), make_native_broadphase());
  warn_within(request.margin, targets, flown);
  ServedFlight flight;
  flight.least_clearance = kInfinity;
  const auto look = [&] {
    for (const std::size_t mover : movers)
      flight.places.push_back(flown.world().actual_pose(flown.object(mover)).p);
  };
  Followers followers(scene, targets);
  ContactTeller teller(targets);
  look();
  followers.look(flown);
  for (std::uint64_t k = 0; k + 1 < scene.frame_count(); ++k) {
    const FrameReport report = flown.step();
    flight.pairs += report.candidate_pairs;
    teller.note(report, flown, flight);
    look();
    followers.follow(flown);
  }
  flight.seen = followers.take();
  return flight;
}

/// Whether a hexahedron of the other is wholly inside the mesh's solid at some time: it then meets no
/// triangle, but every cover. Of another mesh, whose hexahedra are its triangles' plates, the first stands
/// for all.
bool is_once_inside(const MeshDistance& mesh, const SeenObject& other, const HexahedronTree& tree) {
  const auto is_inside = [&](const Vector3& p) {
    return (p - mesh.bounds().low).minCoeff() > 0.0 && (mesh.bounds().high - p).minCoeff() > 0.0 &&
           mesh.is_inside(p);
  };
  for (const PlacedHexahedron& each : tree.solids()) {
    const std::array<Vector3, 8> vertices = each.solid.vertices();
    for (const Pose& X_TO : other.X_TO) {
      const Pose X_TS = compose(X_TO, each.X_OS);
      if (std::all_of(vertices.begin(), vertices.end(),
                      [&](const Vector3& v) { return is_inside(transform(X_TS, v)); }))
        return true;
    }
    if (other.mesh) break;
  }
  return false;
}

}  // namespace

void validate(const ServesRequest& request) {
  const std::vector<std::size_t> targets = indices_of(request);
  static_cast<void>(movers_of(request.scene));
  for (std::size_t m = 0; m < targets.size(); ++m)
    if (those_that_may_meet(request.scene, targets[m]).empty())
      reject("--serves", "nothing can meet object '" + request.meshes[m].object + "' in scene '" +
                             request.scene.name + "'");
}

bool may_meet_each_other(const ServesRequest& request) {
  const std::vector<std::size_t> targets = indices_of(request);
  for (const std::size_t a : targets)
    for (const std::size_t b : targets)
      if (may_meet(request.scene, a, b)) return true;
  return false;
}

ServedFlight fly_scene(const ServesRequest& request, std::span<const Fit* const> covers) {
  // The scene, its meshes replaced by their covers.
  const std::vector<std::size_t> targets = indices_of(request);
  const Scene scene = with_trees(request, trees_of(request, covers), targets);
  ServedFlight flight = follow_flight(request, scene, targets);
  // Times come from flights of their own, in which nobody looks.
  std::vector<double> times = frame_times(request, scene, targets);
  if (!times.empty()) {
    std::sort(times.begin(), times.end());
    flight.frame_us = times[times.size() / 2];
    flight.frame_999_us = times[(999 * times.size()) / 1000];
    flight.slowest_us = times.back();
  }
  return flight;
}

std::optional<ServedFlight> fly_meshes(const ServesRequest& request, std::span<const MeshDistance> meshes) {
  std::vector<HexahedronTree> trees;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    std::optional<HexahedronTree> tree =
        surface_tree(meshes[m].mesh(), kSkin * request.tolerance, request.meshes[m].object);
    if (!tree) return std::nullopt;
    trees.push_back(std::move(*tree));
  }
  const std::vector<std::size_t> targets = indices_of(request);
  const Scene scene = with_trees(request, std::move(trees), targets);
  ServedFlight flight = follow_flight(request, scene, targets);
  for (std::size_t m = 0; m < meshes.size(); ++m)
    for (const SeenObject& other : flight.seen[m])
      if (is_once_inside(meshes[m], other, scene.objects[other.object].tree)) return std::nullopt;
  return flight;
}

}  // namespace touchstone::fitting
