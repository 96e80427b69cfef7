#include "touchstone/contact_core/world/model/world_model.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "touchstone/contact_core/geometry/norms.hpp"
#include "touchstone/contact_core/motion/clear_stretch.hpp"
#include "touchstone/contact_core/motion/kept_gap.hpp"
#include "touchstone/contact_core/world/model/frame_lanes.hpp"

namespace touchstone {
namespace {

/// Rounding of bounds.
constexpr double kUp = 1.0 + 0x1p-20;

}  // namespace

Pose WorldModel::pose_on_link(std::uint32_t slot, const Pose& X_WL) const {
  const Rides::Ride* ride = rides.find(objects[slot].root);
  const Pose X_WB = ride == nullptr ? X_WL : compose(X_WL, ride->X_LR);
  return objects[slot].body == slot ? X_WB : compose(X_WB, objects.poses_in_body()[slot]);
}

BodyState WorldModel::state_at(std::uint32_t slot, double s) const {
  const MechanismMover* mover = arm_of(slot);
  if (mover == nullptr) return paths[objects[slot].root].at(slot, s);
  BodyState state = mover->path.at(link_of(slot), s);
  state.X_WO = pose_on_link(slot, state.X_WO);
  return state;
}

bool WorldModel::go_as_one(const SolidPair& pair) const {
  const std::uint32_t a = layout.slot_of[pair.a], b = layout.slot_of[pair.b];
  if (objects[a].root == objects[b].root) return false;
  const MechanismMover* mover = arm_of(a);
  return mover != nullptr && mover == arm_of(b) &&
         mover->rigid_with[link_of(a)] == mover->rigid_with[link_of(b)];
}

bool WorldModel::moves(std::uint32_t slot) const {
  const MechanismMover* mover = arm_of(slot);
  return mover == nullptr || mover->path.moves(link_of(slot));
}

double WorldModel::gap_at(double distance) const {
  return kept_gap(gap, separations().capabilities().resolution, distance);
}

double WorldModel::gap_of(const SolidPair& pair) const {
  // A carried object rounds as its body does, which may be further out.
  const auto reach = [&](SolidIndex i) {
    const Sphere& sphere = layout.solids[i].bounding_sphere();
    const double body = norm_inf(objects[body_of(i)].X_WO.p);
    return std::max(body, norm_inf(from[i].p)) + norm(sphere.centre) + 2.0 * sphere.radius;
  };
  return gap_at(std::max(reach(pair.a), reach(pair.b)));
}

double WorldModel::contact_reach(SolidIndex solid, double travel) const {
  const Sphere& sphere = layout.solids[solid].bounding_sphere();
  const double size = norm(X_BS[solid].p) + norm(sphere.centre) + 2.0 * sphere.radius;
  return std::max(2.0 * gap_at(norm_inf(from[solid].p) + size + travel) - margin, 0.0);
}

double WorldModel::contact_reach_of_object(std::uint32_t slot, double travel) const {
  const double size = norm(objects.poses_in_body()[slot].p) + layout.levels[slot]->extent();
  return std::max(2.0 * gap_at(norm_inf(objects[slot].X_WO.p) + 2.0 * size + travel) - margin, 0.0);
}

PairDistances WorldModel::most_distances() const {
  const double most_gap = gap_at((furthest + largest_extent) * kUp);
  return {most_gap, std::max(2.0 * most_gap, rules.largest_warn_distance())};
}

bool WorldModel::is_checked(const SolidPair& pair) const {
  const std::uint32_t a = layout.slot_of[pair.a], b = layout.slot_of[pair.b];
  if (objects[a].body == objects[b].body || (objects[a].is_static() && objects[b].is_static())) return false;
  return selection.is_on(objects, a, b) && !layout.is_exempt(pair);
}

std::uint32_t WorldModel::link_pair_index(const SolidPair& pair) const {
  const std::uint32_t a = body_of(pair.a), b = body_of(pair.b);
  if (objects[a].root != objects[b].root || !objects[a].is_link()) return kNoLinkPair;
  const MechanismMover& mover = *mechanisms.at(objects[a].mechanism);
  const auto links = static_cast<std::uint32_t>(mover.X_WL.size());
  const auto [low, high] = std::minmax(objects[a].link, objects[b].link);
  return mover.first_link_pair + low * links + high;
}

FramePair WorldModel::frame_pair(const SolidPair& pair) const {
  FramePair entry;
  entry.solids = pair;
  entry.rule = rules.find(objects, layout.slot_of[pair.a], layout.slot_of[pair.b]);
  entry.gap = gap_of(pair);
  entry.interest = std::max(2.0 * entry.gap, entry.rule.warn_distance);
  entry.link_pair = link_pair_index(pair);
  return entry;
}

MovingSolid WorldModel::moving_solid(SolidIndex solid) const {
  const std::uint32_t slot = layout.slot_of[solid], root = objects[slot].root;
  MovingSolid out{&layout.solids[solid], layout.X_OS[solid], &paths[root], slot};
  out.stop = in_motion[root] ? stops[root] : 0.0;
  out.travel = travels.last_solid[solid];
  const Rides::Ride* ride = rides.find(root);
  if (MechanismMover* mover = arm_of(slot)) {
    out.X_OS = ride == nullptr ? X_BS[solid] : compose(ride->X_LR, X_BS[solid]);
    out.path = &mover->path, out.body = link_of(slot), out.views = mover;
  }
  // A carried object's pose is where it was carried to, which its path gives to rounding only.
  if (objects[slot].body == slot && ride == nullptr && travels.has_vertices[solid])
    out.X_WS_at_start = &from[solid], out.vertices_at_start = &travels.vertices[solid];
  return out;
}

std::pair<MovingSolid, MovingSolid> WorldModel::seen_from_earlier_link(const SolidPair& pair,
                                                                       double travel) const {
  const bool is_a = is_a_on_earlier_link(pair);
  MechanismMover& mover = *mechanism_of(layout.slot_of[pair.a]);
  const std::uint32_t link = objects[body_of(is_a ? pair.a : pair.b)].link;
  const auto seen = [&](SolidIndex solid, double own_travel) {
    MovingSolid out = moving_solid(solid);
    out.path = &mover.relative.seen_from(link, mover.path);
    out.vertices_at_start = nullptr;
    out.travel = own_travel;
    return out;
  };
  return {seen(pair.a, is_a ? 0.0 : travel), seen(pair.b, is_a ? travel : 0.0)};
}

double WorldModel::travel_on(const MechanismMover& mover, SolidIndex solid) const {
  return travel_on(mover, layout.slot_of[solid], sphere_B[solid]);
}

void WorldModel::measure_travels(const MechanismMover& mover, std::uint32_t slot,
                                 GrowingList<double>& out) const {
  if (layout.levels[slot] != nullptr || rides.find(objects[slot].root) != nullptr) {
    for_each_solid_of(slot, [&](SolidIndex solid) { out[solid] = travel_on(mover, solid); });
    return;
  }
  const SolidIndex first = layout.first_solid[slot], count = layout.first_solid[slot + 1] - first;
  if (count == 0) return;
  const std::span<double> speeds(&out[first], count);
  mover.path.speed_bounds(link_of(slot), {&sphere_B[first], count}, speeds);
  for (double& speed : speeds) speed *= kUp;
}

double WorldModel::travel_on(const MechanismMover& mover, std::uint32_t slot, const Sphere& within_B) const {
  const std::uint32_t link = link_of(slot);
  const Rides::Ride* ride = rides.find(objects[slot].root);
  const Vector3& in_body = within_B.centre;
  return (mover.path.speed_bound(link, ride == nullptr ? in_body : transform(ride->X_LR, in_body)) +
          mover.path.turn_bound(link) * within_B.radius) *
         kUp;
}

/// Of two links each joint between them moves the outer one's points about it: by its change times how far
/// the joint is from the furthest of them, at most.
void WorldModel::measure_link_travels(const MechanismMover& mover, std::vector<double>& out) const {
  const std::span<double> of_pairs = std::span(out).subspan(mover.first_link_pair, mover.link_pairs());
  std::fill(of_pairs.begin(), of_pairs.end(), 0.0);
  for (std::uint32_t k = 0; k < mover.actual.size(); ++k) {
    const double change = std::abs(mover.path.to()[k] - mover.path.from()[k]);
    if (change == 0.0) continue;
    for (const auto& [place, outer] : mover.moved_by(k))
      of_pairs[place] += change * mover.frame.furthest(k, outer, mover.radius_of_link[outer]);
  }
  for (double& travel : of_pairs) travel *= kUp;
}

namespace {

/// Of two that go as one: how they stand is all there is.
Impact standing(const WorldModel& model, NarrowphaseQuery& query, const SolidPair& pair) {
  Impact impact;
  query.set_pair(pair);
  const PairStatus status = query.separation(model.from[pair.a], model.from[pair.b], impact.geometry);
  if (!has_geometry(status)) return impact;
  impact.queries = 1;
  impact.start_separation = impact.least_separation = impact.geometry.separation;
  impact.starts_overlapping = impact.start_separation < 0.0;
  impact.lo = 1.0;
  return impact;
}

}  // namespace

Impact impact_of(const WorldModel& model, NarrowphaseQuery& query, FramePair& pair, double until) {
  const double now = model.travelled(pair.solids, pair.link_pair);
  if (now <= pair.clear_until) {
    Impact clear;
    clear.geometry.n_AB_W = clear.geometry.p_A_W = clear.geometry.p_B_W = Vector3::Zero();
    clear.is_far = true;
    return clear;
  }
  if (model.go_as_one(pair.solids)) return standing(model, query, pair.solids);
  query.set_pair(pair.solids);
  const auto [a, b] = pair.solids;
  MovingSolid first = model.moving_solid(a), second = model.moving_solid(b);
  if (pair.link_pair != kNoLinkPair)
    std::tie(first, second) =
        model.seen_from_earlier_link(pair.solids, model.travels.last_link_pair[pair.link_pair]);
  const Impact impact = find_impact(first, second, {pair.gap}, query, pair.interest, until, false);
  if (query.judges_poses()) return impact;  // separations say nothing about what such a backend sees
  // The gap is far more than separations and sums round.
  const double room = impact.start_separation - pair.interest - pair.gap;
  if (impact.queries > 0 && room > 0.0 && now <= Travels::kMost)
    pair.clear_until =
        now * (1.0 - 0x1p-50) - model.last_travel(pair.solids, pair.link_pair) * (1.0 + 0x1p-19) + room;
  return impact;
}

std::uint32_t mover_of(const WorldModel& model, const SolidPair& pair) {
  const std::uint32_t a = model.root_of(pair.a), b = model.root_of(pair.b);
  const GrowingList<std::uint8_t>& in_motion = model.in_motion;
  if (a == b) return a;
  const auto lead_of = [&](std::uint32_t root) {
    const Rides::Ride* ride = model.rides.find(root);
    return ride == nullptr ? root : ride->lead;
  };
  if (!in_motion[a]) return in_motion[b] ? lead_of(b) : kAlone;
  if (!in_motion[b]) return lead_of(a);
  const bool is_arm_a = model.arm_of(a) != nullptr, is_arm_b = model.arm_of(b) != nullptr;
  if (is_arm_a && is_arm_b) return kInTurn;
  return is_arm_a ? lead_of(a) : is_arm_b ? lead_of(b) : kAlone;
}

void find_impact_of(const WorldModel& model, NarrowphaseQuery& query, WatchedPair& watch, FramePair& pair,
                    const SeparationMemo::Answer* start, double until) {
  pair.clear_until = watch.clear_until;
  if (start != nullptr)
    query.expect(pair.solids, model.from[pair.solids.a], model.from[pair.solids.b], *start);
  pair.impact = impact_of(model, query, pair, until);
  query.expect_nothing();
  // What was known before holds still, and may be more by rounding.
  watch.clear_until = std::max(watch.clear_until, pair.clear_until);
  if (pair.impact.queries > 0) watch.axis_W = pair.impact.geometry.n_AB_W;
}

void place_vertices(WorldModel& model, FrameLanes& lanes, const PairWatch& watched,
                    std::span<const std::uint32_t> watches) {
  constexpr std::size_t kSolidsAtOnce = 64;
  Travels& travels = model.travels;
  travels.unplaced.clear();
  for (const std::uint32_t i : watches)
    for (const SolidIndex solid : {watched[i].a, watched[i].b}) {
      if (travels.has_vertices[solid]) continue;
      travels.has_vertices[solid] = 1;
      travels.unplaced.push_back(solid);
    }
  lanes.for_each(travels.unplaced.size(), kSolidsAtOnce, [&](NarrowphaseQuery&, std::size_t i) {
    const SolidIndex solid = travels.unplaced[i];
    world_vertices(model.layout.solids[solid], model.from[solid], travels.vertices[solid]);
  });
}

const WorldVertices& vertices_of(WorldModel& model, SolidIndex solid) {
  Travels& travels = model.travels;
  if (travels.has_vertices[solid]) return travels.vertices[solid];
  world_vertices(model.layout.solids[solid], model.from[solid], travels.vertices[solid]);
  travels.has_vertices[solid] = 1;
  return travels.vertices[solid];
}

double apart_at_least(WorldModel& model, const WatchedPair& watch) {
  const WorldVertices &a = vertices_of(model, watch.a), &b = vertices_of(model, watch.b);
  Vector3 n = watch.axis_W;
  if (n == Vector3::Zero()) {
    const auto centre_of = [&](SolidIndex solid) {
      return transform(model.from[solid], model.layout.solids[solid].bounding_sphere().centre);
    };
    const Vector3 offset = centre_of(watch.b) - centre_of(watch.a);
    const double length = norm(offset);
    if (!(length > 0.0)) return -1.0;
    n = offset / length;
  }
  double highest = dot(n, a.vertex(0)), lowest = dot(n, b.vertex(0));
  for (int i = 1; i < Hexahedron::kVertices; ++i) {
    highest = std::max(highest, dot(n, a.vertex(i)));
    lowest = std::min(lowest, dot(n, b.vertex(i)));
  }
  const GrowingList<Hexahedron>& solids = model.layout.solids;
  return (lowest - highest) - (solids[watch.a].radius() + solids[watch.b].radius());
}

bool is_apart_by_axis(WorldModel& model, WatchedPair& watch, const PairDistances& pair, double standing,
                      double travel) {
  if (model.is_sampled() || !(standing <= Travels::kMost)) return false;
  // The gap is far more than separations and sums round.
  const double room = apart_at_least(model, watch) - pair.interest - pair.gap;
  if (!(room > travel)) return false;
  watch.clear_until = std::max(watch.clear_until, standing + room);
  return true;
}

}  // namespace touchstone
