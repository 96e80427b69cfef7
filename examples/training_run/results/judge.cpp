#include "touchstone/examples/training_run/results/judge.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "touchstone/adapters/exact/exact.hpp"
#include "touchstone/adapters/exact/signed_distance.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/norms.hpp"
#include "touchstone/contact_core/mechanism/mechanism_path.hpp"
#include "touchstone/contact_core/motion/impact.hpp"
#include "touchstone/contact_core/motion/kept_gap.hpp"
#include "touchstone/contact_core/motion/narrowphase_query.hpp"
#include "touchstone/contact_core/registry.hpp"

namespace touchstone::training {
namespace {

/// Paths are looked at this often [m], and no more than this many times a frame.
constexpr double kLookEvery = 0.001;
constexpr std::size_t kMostLooks = 4096;

/// The world vertices of a solid and a box around it: exact, doubles are only compared, but for a radius.
struct PosedSolid {
  WorldVertices vertices;
  double radius;
  std::array<double, 3> low, high;
};

PosedSolid posed(const Hexahedron& solid, const Pose& X_WS) {
  PosedSolid out;
  world_vertices(solid, X_WS, out.vertices);
  out.radius = solid.radius();
  const WorldVertices& v = out.vertices;
  const std::array<const std::array<double, 8>*, 3> axes{&v.x, &v.y, &v.z};
  for (std::size_t i = 0; i < 3; ++i) {
    out.low[i] = *std::min_element(axes[i]->begin(), axes[i]->end());
    out.high[i] = *std::max_element(axes[i]->begin(), axes[i]->end());
    if (out.radius == 0.0) continue;
    out.low[i] = std::nextafter(out.low[i] - out.radius, -kInfinity);
    out.high[i] = std::nextafter(out.high[i] + out.radius, kInfinity);
  }
  return out;
}

double separation_of(const PosedSolid& a, const PosedSolid& b) {
  if (a.radius == 0.0 && b.radius == 0.0) return exact_signed_distance(a.vertices, b.vertices).separation;
  return exact_rounded_distance(a.vertices, a.radius, b.vertices, b.radius).separation;
}

bool are_apart(const PosedSolid& a, const PosedSolid& b) {
  if (a.radius == 0.0 && b.radius == 0.0)  // cheaper
    return exact_pair_class(a.vertices, b.vertices) == PairClass::separated;
  return exact_rounded_distance(a.vertices, a.radius, b.vertices, b.radius).pair_class ==
         PairClass::separated;
}

/// No more than the distance of the two, to rounding; below or 0 where the boxes meet.
double distance_of_boxes(const PosedSolid& a, const PosedSolid& b) {
  double square = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double gap = std::max({0.0, b.low[i] - a.high[i], a.low[i] - b.high[i]});
    square += gap * gap;
  }
  return std::sqrt(square);
}

bool boxes_are_apart(const PosedSolid& a, const PosedSolid& b) {
  for (std::size_t i = 0; i < 3; ++i)
    if (b.low[i] > a.high[i] || a.low[i] > b.high[i]) return true;
  return false;
}

/// Their product; where one is the identity, the bits of the other.
Pose on_body(const Pose& X, const Pose& Y) {
  if (is_same(Y, {})) return X;
  return is_same(X, {}) ? Y : compose(X, Y);
}

/// The paths of a frame: of free objects, by object, with what they carry; and of arms.
struct FramePaths {
  std::vector<CarriedPath> free;
  std::vector<MechanismPath> arms;
};

struct Contact {
  std::size_t pair;
  double separation;  ///< <= 0
};

}  // namespace

struct Judge::State {
  const Setting& setting;
  std::unique_ptr<Narrowphase> exact;
  mutable NarrowphaseQuery query;
  std::vector<double> start_separation;  ///< of pairs that overlap at the start; 0 of others

  static std::unique_ptr<Narrowphase> make_exact(const Setting& setting) {
    BackendRegistry registry;
    register_exact(registry);
    std::unique_ptr<Narrowphase> exact = registry.make_narrowphase("exact");
    exact->build(setting.instance().solids());
    return exact;
  }

  explicit State(const Setting& given)
      : setting(given), exact(make_exact(given)), query(*exact, given.instance().solids().size()) {
    std::vector<Pose> X_WO;
    for (const SceneObject& object : setting.scene().objects) X_WO.push_back(object.X_WO);
    start_separation.assign(setting.pairs().size(), 0.0);
    for (const Contact& contact : contacts(X_WO, Formation(X_WO.size())))
      start_separation[contact.pair] = contact.separation;
  }

  const PlacedHexahedron& placed(SolidIndex solid) const {
    const std::uint32_t object = setting.instance().object_of(solid);
    return setting.instance().trees()[object]->solids()[solid - setting.instance().first_solid(object)];
  }
  std::uint32_t object_of(SolidIndex solid) const { return setting.instance().object_of(solid); }

  PosedSolid pose_one(SolidIndex i, std::span<const Pose> X_WO) const {
    return posed(placed(i).solid, compose(X_WO[object_of(i)], placed(i).X_OS));
  }

  std::vector<PosedSolid> pose_all(std::span<const Pose> X_WO) const {
    std::vector<PosedSolid> solids;
    solids.reserve(setting.instance().solids().size());
    for (SolidIndex i = 0; i < setting.instance().solids().size(); ++i) solids.push_back(pose_one(i, X_WO));
    return solids;
  }

  std::vector<Contact> contacts(std::span<const Pose> X_WO, const Formation& formation) const {
    const std::vector<PosedSolid> solids = pose_all(X_WO);
    std::vector<Contact> found;
    for (std::size_t i = 0; i < setting.pairs().size(); ++i) {
      const SolidPair& pair = setting.pairs()[i];
      const PosedSolid &a = solids[pair.a], &b = solids[pair.b];
      if (!formation.is_checked(pair, setting.instance()) || boxes_are_apart(a, b)) continue;
      if (are_apart(a, b)) continue;
      found.push_back({i, separation_of(a, b)});
    }
    return found;
  }

  double separation(const SolidPair& pair, std::span<const Pose> X_WO) const {
    return separation_of(pose_one(pair.a, X_WO), pose_one(pair.b, X_WO));
  }

  double scale_of(const SolidPair& pair, std::span<const Pose> X_WO) const {
    double scale = 0.0;
    for (const SolidIndex solid : {pair.a, pair.b}) {
      const Pose X_WS = compose(X_WO[object_of(solid)], placed(solid).X_OS);
      const Sphere& sphere = placed(solid).solid.bounding_sphere();
      scale = std::max(scale, norm_inf(X_WS.p) + norm(sphere.centre) + 2.0 * sphere.radius);
    }
    return scale;
  }

  /// True where the pair overlapped at the start and is no deeper now, to the rounding of a separation.
  bool is_old(const Contact& contact, std::span<const Pose> X_WO) const {
    const double start = start_separation[contact.pair];
    return start < 0.0 &&
           contact.separation >= start - 0x1p-48 * scale_of(setting.pairs()[contact.pair], X_WO);
  }

  // ---- paths

  FramePaths paths_at_rest(const FlightLog& log, std::size_t frame) const {
    FramePaths paths;
    const Formation& formation = log.formations[log.formation[frame]];
    for (const Pose& X : log.shown(frame)) paths.free.emplace_back(RigidPath(X), formation.X_RO);
    for (const Arm& arm : setting.arms()) paths.arms.emplace_back(*arm.mechanism);
    return paths;
  }

  static std::span<const double> values_of(const Arm& arm, std::span<const double> values) {
    return values.subspan(arm.first_value, arm.joints.size());
  }

  std::size_t index_of(const Arm& arm) const {
    return static_cast<std::size_t>(&arm - setting.arms().data());
  }

  /// Every path of a frame: as commanded.
  FramePaths commanded_paths(const FlightLog& log, std::size_t frame) const {
    const Formation& formation = log.formations[log.formation[frame]];
    FramePaths paths = paths_at_rest(log, frame);
    for (std::size_t hand = 0; hand < log.hands; ++hand)
      if (!setting.script().hands[hand].arm)
        paths.free[setting.object_of_hand(hand)] = CarriedPath(log.path(frame, hand), formation.X_RO);
    for (const Arm& arm : setting.arms())
      paths.arms[index_of(arm)].set(arm.X_WB, values_of(arm, log.shown_joints(frame)),
                                    values_of(arm, log.goals(frame)));
    return paths;
  }

  /// As executed. Of a slide nothing but its ends is known here: it counts as at rest where it ended.
  FramePaths executed_paths(const FlightLog& log, std::size_t frame) const {
    const Formation& formation = log.formations[log.formation[frame]];
    const bool slid = log.slide_steps[frame] > 0;
    FramePaths paths = commanded_paths(log, frame);
    for (std::uint32_t i = 0; i < paths.free.size(); ++i) {
      const Pose &before = log.shown(frame)[i], &after = log.shown(frame + 1)[i];
      if (formation.carrier[i] != kNone || is_same(paths.free[i].carrier().to(), after)) continue;
      paths.free[i] = CarriedPath(RigidPath::between(slid ? after : before, after), formation.X_RO);
    }
    for (const Arm& arm : setting.arms()) {
      const std::span<const double> after = values_of(arm, log.shown_joints(frame + 1));
      paths.arms[index_of(arm)].set(arm.X_WB, slid ? after : values_of(arm, log.shown_joints(frame)), after);
    }
    return paths;
  }

  /// The body of a path that an object is on, and where the object is in that body.
  struct BodyPath {
    const MotionPath* path;
    std::uint32_t body;
    Pose X_BO;
  };
  BodyPath path_of(std::uint32_t object, const FramePaths& paths, const Formation& formation) const {
    const std::uint32_t root = formation.root_of(object);
    if (const Arm* arm = setting.arm_of(root))
      return {&paths.arms[index_of(*arm)], arm->link_of_object[root - arm->first_object],
              formation.X_RO[object]};
    return {&paths.free[root], object, {}};
  }

  std::vector<Pose> poses_on(const FramePaths& paths, const Formation& formation, double s) const {
    std::vector<Pose> X_WO(paths.free.size());
    for (std::uint32_t i = 0; i < X_WO.size(); ++i) {
      const BodyPath on = path_of(i, paths, formation);
      X_WO[i] = on_body(on.path->at(on.body, s).X_WO, on.X_BO);
    }
    return X_WO;
  }

  /// No point of the object goes further than this in the frame [m].
  double travel_of(std::uint32_t object, const FramePaths& paths, const Formation& formation) const {
    const Sphere& sphere = setting.instance().trees()[object]->nodes()[0].sphere_O;
    const BodyPath on = path_of(object, paths, formation);
    if (const Arm* arm = setting.arm_of(formation.root_of(object))) {
      const MechanismPath& path = paths.arms[index_of(*arm)];
      return path.speed_bound(on.body, transform(on.X_BO, sphere.centre)) +
             path.turn_bound(on.body) * sphere.radius;
    }
    const BodyState state = on.path->at(on.body, 0.0);
    const double reach = norm(transform(state.X_WO, sphere.centre) - state.centre_W) + sphere.radius;
    return norm(state.velocity_W) + norm(state.angular_velocity_W) * reach;
  }

  std::size_t looks_for(const FramePaths& paths, const Formation& formation) const {
    double longest = 0.0;
    for (std::uint32_t i = 0; i < paths.free.size(); ++i)
      longest = std::max(longest, travel_of(i, paths, formation));
    return std::min(kMostLooks, static_cast<std::size_t>(std::ceil(longest / kLookEvery)));
  }

  /// The deepest depth between the ends of a frame.
  double deepest_within(const FlightLog& log, std::size_t frame) const {
    const Formation& formation = log.formations[log.formation[frame]];
    const FramePaths paths = executed_paths(log, frame);
    const std::size_t looks = looks_for(paths, formation);
    double deepest = 0.0;
    for (std::size_t look = 1; look < looks; ++look) {
      const double s = static_cast<double>(look) / static_cast<double>(looks);
      for (const Contact& contact : contacts(poses_on(paths, formation, s), formation))
        deepest = std::max(deepest, -contact.separation);
    }
    return deepest;
  }

  // ---- blocked frames

  MovingSolid moving(SolidIndex solid, const FramePaths& paths, const Formation& formation,
                     double stop) const {
    const BodyPath on = path_of(object_of(solid), paths, formation);
    return {&placed(solid).solid, on_body(on.X_BO, placed(solid).X_OS), on.path, on.body, stop};
  }

  /// The object that stands for all that moves with the solid.
  std::uint32_t mover_of(SolidIndex solid, const Formation& formation) const {
    return setting.mover_of(formation.root_of(object_of(solid)));
  }

  bool is_passive(SolidIndex solid, const Formation& formation) const {
    return setting.may_be_taken_along(formation.root_of(object_of(solid)));
  }

  /// Where a mover was stopped by other pairs in this frame.
  double stop_by_others(std::uint32_t mover, const SolidPair& pair, std::span<const LoggedEvent> events,
                        const Formation& formation) const {
    double stop = 1.0;
    for (const LoggedEvent& event : events) {
      if (event.kind != EventKind::blocked || event.solids == pair) continue;
      if (mover_of(event.solids.a, formation) != mover && mover_of(event.solids.b, formation) != mover)
        continue;
      stop = std::min(stop, setting.scene().policy == ContactPolicy::hold ? 0.0 : event.s);
    }
    return stop;
  }

  std::size_t index_of(const SolidPair& pair) const {
    return static_cast<std::size_t>(std::lower_bound(setting.pairs().begin(), setting.pairs().end(), pair) -
                                    setting.pairs().begin());
  }

  /// Of the pair where the paths have it at s.
  double separation_on(const SolidPair& pair, const FramePaths& paths, const Formation& formation,
                       double s) const {
    return separation(pair, poses_on(paths, formation, s));
  }

  bool is_rightly_blocked(const SolidPair& pair, std::uint32_t mover, std::span<const LoggedEvent> events,
                          const FramePaths& paths, const Formation& formation) const {
    const auto solid = [&](SolidIndex index) {
      const std::uint32_t own = mover_of(index, formation);
      return moving(index, paths, formation,
                    own == mover ? 1.0 : stop_by_others(own, pair, events, formation));
    };
    query.set_pair(pair);
    const GapRule rule{setting.scene().contact_gap};
    // In a contact that a check would not have let come about, all but the way out is rightly refused.
    if (start_separation[index_of(pair)] == 0.0) {
      const double now = separation_on(pair, paths, formation, 0.0);
      if (now < 0.0) return separation_on(pair, paths, formation, 1.0) <= now;
    }
    return find_impact(solid(pair.a), solid(pair.b), rule, query, 2.0 * rule.gap).status !=
           ImpactStatus::clear;
  }

  bool is_at_rest(const FlightLog& log, std::size_t frame, std::size_t hand) const {
    const Arm* arm = setting.arm_of(setting.object_of_hand(hand));
    if (arm == nullptr) return log.path(frame, hand).at_rest();
    const std::span<const double> from = values_of(*arm, log.shown_joints(frame));
    return std::equal(from.begin(), from.end(), values_of(*arm, log.goals(frame)).begin());
  }

  /// Commanded in a frame that stopped others, and did not move.
  static bool is_held(const FlightLog& log, std::size_t frame, std::uint32_t mover, const Arm* arm) {
    if (arm == nullptr) return is_same(log.shown(frame)[mover], log.shown(frame + 1)[mover]);
    const std::span<const double> before = values_of(*arm, log.shown_joints(frame));
    return std::equal(before.begin(), before.end(), values_of(*arm, log.shown_joints(frame + 1)).begin());
  }

  bool is_false_stop(const FlightLog& log, std::size_t frame, std::span<const LoggedEvent> events) const {
    const Formation& formation = log.formations[log.formation[frame]];
    const FramePaths paths = commanded_paths(log, frame);
    for (std::size_t hand = 0; hand < log.hands; ++hand) {
      const std::uint32_t mover = setting.object_of_hand(hand);
      if (is_at_rest(log, frame, hand)) continue;
      bool is_blocked = false, rightly = false;
      for (const LoggedEvent& event : events) {
        if (event.kind != EventKind::blocked || rightly) continue;
        // Reports do not name the mover of a passive object; an object that it met stops both.
        if (is_passive(event.solids.a, formation) || is_passive(event.solids.b, formation))
          is_blocked = rightly = true;
        if (mover_of(event.solids.a, formation) != mover && mover_of(event.solids.b, formation) != mover)
          continue;
        is_blocked = true;
        rightly = is_rightly_blocked(event.solids, mover, events, paths, formation);
      }
      if (is_blocked ? !rightly : is_held(log, frame, mover, setting.arm_of(mover))) return true;
    }
    return false;
  }

  // ---- reports

  static bool reports_contact(EventKind kind) {
    return kind == EventKind::began || kind == EventKind::persists || kind == EventKind::penetrating_at_start;
  }

  static bool is_reported(const SolidPair& pair, std::span<const LoggedEvent> events) {
    return std::any_of(events.begin(), events.end(), [&](const LoggedEvent& event) {
      return reports_contact(event.kind) && event.solids == pair;
    });
  }

  /// Contact that came and went within the frame (it has an `ended`) does not count at its end.
  static bool has_ended(const LoggedEvent& event, std::span<const LoggedEvent> events) {
    return std::any_of(events.begin(), events.end(), [&](const LoggedEvent& other) {
      return other.kind == EventKind::ended && other.solids == event.solids;
    });
  }

  bool is_phantom(std::span<const LoggedEvent> events, std::span<const Pose> X_WO,
                  const Resolution& resolution) const {
    bool any = false;
    for (const LoggedEvent& event : events) {
      if (!reports_contact(event.kind) || has_ended(event, events)) continue;
      any = true;
      const double scale = scale_of(event.solids, X_WO);
      const double gap = kept_gap(setting.scene().contact_gap, resolution, scale);
      if (separation(event.solids, X_WO) <= 2.0 * gap + 0x1p-48 * scale) return false;
    }
    return any;
  }
};

Judge::Judge(const Setting& setting) : state_(std::make_unique<State>(setting)) {}
Judge::~Judge() = default;

std::vector<ShownContact> Judge::contacts(std::span<const Pose> X_WO, const Formation& formation) const {
  std::vector<ShownContact> found;
  for (const Contact& contact : state_->contacts(X_WO, formation))
    found.push_back({state_->setting.pairs()[contact.pair], contact.separation});
  return found;
}

namespace {

bool has_blocked(std::span<const LoggedEvent> events, const SolidPair& pair) {
  return std::any_of(events.begin(), events.end(), [&](const LoggedEvent& event) {
    return event.kind == EventKind::blocked && event.solids == pair;
  });
}

/// The events of each frame in turn.
class EventsByFrame {
 public:
  explicit EventsByFrame(const FlightLog& log) : events_(log.events) {}
  std::span<const LoggedEvent> next(std::size_t frame) {
    std::size_t end = begin_;
    while (end < events_.size() && events_[end].frame == frame) ++end;
    const std::span<const LoggedEvent> found = events_.subspan(begin_, end - begin_);
    begin_ = end;
    return found;
  }

 private:
  std::span<const LoggedEvent> events_;
  std::size_t begin_ = 0;
};

}  // namespace

Verdict Judge::judge(const FlightLog& log, const Resolution& resolution,
                     const measures::Progress& progress) const {
  const State& s = *state_;
  Verdict verdict;
  verdict.frames = log.frames;
  EventsByFrame by_frame(log);
  std::span<const LoggedEvent> events_before;
  std::vector<Contact> contacts = s.contacts(log.shown(0), log.formations[0]);
  for (std::size_t frame = 0; frame < log.frames; ++frame) {
    const std::span<const LoggedEvent> events = by_frame.next(frame);
    // Contacts as they are shown, and deepest on the paths between.
    const std::span<const Pose> before = log.shown(frame), shown = log.shown(frame + 1);
    const Formation& formation = log.formations[log.formation[frame]];
    const bool was_apart = contacts.empty();
    const bool changed = frame == 0 || log.formation[frame] != log.formation[frame - 1] ||
                         !std::equal(before.begin(), before.end(), shown.begin(), is_same);
    const double within = changed ? s.deepest_within(log, frame) : 0.0;
    if (changed) contacts = s.contacts(shown, formation);
    if (was_apart && contacts.empty() && within > 0.0) ++verdict.passed_through;

    // Shown contacts that the method missed, or made up.
    bool wrong = false;
    for (const Contact& contact : contacts) {
      verdict.deepest_shown = std::max(verdict.deepest_shown, -contact.separation);
      const bool may = s.setting.scene().policy == ContactPolicy::cue || s.is_old(contact, shown);
      wrong = wrong || !may || !State::is_reported(s.setting.pairs()[contact.pair], events);
    }
    verdict.deepest_between = std::max({verdict.deepest_between, within, verdict.deepest_shown});
    verdict.merged += !contacts.empty();
    verdict.missed += wrong;
    verdict.phantom += s.is_phantom(events, shown, resolution);

    // Cues and stops, and frames that were stopped without need.
    bool blocked = false;
    for (const LoggedEvent& event : events) {
      const double time =
          s.setting.time(frame) + event.s * (s.setting.time(frame + 1) - s.setting.time(frame));
      if (event.kind == EventKind::began || event.kind == EventKind::ended ||
          event.kind == EventKind::penetrating_at_start)
        verdict.cues.push_back({event.kind, time, event.solids});
      if (event.kind != EventKind::blocked) continue;
      blocked = true;
      if (!has_blocked(events_before, event.solids))
        verdict.stops.push_back({time, event.solids, s.separation(event.solids, shown)});
    }
    verdict.blocked += blocked;
    if (blocked) verdict.false_stops += s.is_false_stop(log, frame, events);
    events_before = events;
    if (progress) progress(static_cast<double>(frame + 1) / static_cast<double>(log.frames));
  }
  verdict.last.assign(log.shown(log.frames).begin(), log.shown(log.frames).end());
  return verdict;
}

std::vector<SeparationPoint> Judge::separations(const FlightLog& log, std::size_t first,
                                                std::size_t last) const {
  const State& s = *state_;
  std::vector<SeparationPoint> points;
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t frame = first; frame <= std::min(last, log.frames); ++frame) {
    // A frame's checks were those of the formation before it.
    const Formation& formation = log.formations[log.formation[frame == 0 ? 0 : frame - 1]];
    const std::vector<PosedSolid> solids = s.pose_all(log.shown(frame));
    // Distances of boxes are lower bounds, which put near pairs first.
    order.clear();
    for (std::size_t i = 0; i < s.setting.pairs().size(); ++i) {
      const SolidPair& pair = s.setting.pairs()[i];
      const bool is_own = s.mover_of(pair.a, formation) == s.mover_of(pair.b, formation);  // links of one arm
      if (formation.is_checked(pair, s.setting.instance()) && !is_own)
        order.emplace_back(distance_of_boxes(solids[pair.a], solids[pair.b]), i);
    }
    std::sort(order.begin(), order.end());
    // The exact separations end the search as soon as no bound is below the least.
    double least = kInfinity;
    for (const auto& [bound, i] : order) {
      if (bound > least) break;
      const SolidPair& pair = s.setting.pairs()[i];
      least = std::min(least, separation_of(solids[pair.a], solids[pair.b]));
    }
    points.push_back({s.setting.time(frame), least});
  }
  return points;
}

}  // namespace touchstone::training
