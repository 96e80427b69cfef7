#include "touchstone/adapters/bullet_plugin/manifold_update.hpp"

#include <algorithm>
#include <new>
#include <optional>
#include <utility>

#include "touchstone/adapters/bullet_plugin/shape_content.hpp"

namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE {
namespace {

constexpr int kNone = -1;
using Slots = std::array<int, MANIFOLD_CACHE_SIZE>;

bool has_flag(const btCollisionObject& a, const btCollisionObject& b, int flag) {
  return ((a.getCollisionFlags() | b.getCollisionFlags()) & flag) != 0;
}

/// Data that the points of a pair share.
struct Shared {
  btScalar friction, restitution, rolling_friction, spinning_friction;
  btScalar damping = 0, stiffness = 0;
  int flags = 0;
  btVector3 friction_direction_1, friction_direction_2;

  Shared(const btCollisionObject& a, const btCollisionObject& b, const btVector3& normal_on_B)
      : friction(btManifoldResult::calculateCombinedFriction(&a, &b)),
        restitution(btManifoldResult::calculateCombinedRestitution(&a, &b)),
        rolling_friction(btManifoldResult::calculateCombinedRollingFriction(&a, &b)),
        spinning_friction(btManifoldResult::calculateCombinedSpinningFriction(&a, &b)) {
    if (has_flag(a, b, btCollisionObject::CF_HAS_CONTACT_STIFFNESS_DAMPING)) {
      damping = btManifoldResult::calculateCombinedContactDamping(&a, &b);
      stiffness = btManifoldResult::calculateCombinedContactStiffness(&a, &b);
      flags |= BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING;
    }
    if (has_flag(a, b, btCollisionObject::CF_HAS_FRICTION_ANCHOR)) flags |= BT_CONTACT_FLAG_FRICTION_ANCHOR;
    btPlaneSpace1(normal_on_B, friction_direction_1, friction_direction_2);
  }
};

btVector3 point_on_A(const FoundPoint& found) {
  return found.point_on_B + found.normal_on_B * found.distance;
}

btVector3 local_point_on_A(const ObjectPair& objects, const btVector3& on_A) {
  return objects.a.getCollisionObject()->getWorldTransform().invXform(on_A);
}

/// Writes a point into `slot` as btManifoldResult::addContactPoint would.
void make_point(const ObjectPair& objects, const Shared& shared, const FoundPoint& found,
                btManifoldPoint& slot) {
  const btTransform& X_WB = objects.b.getCollisionObject()->getWorldTransform();
  const btVector3 on_A = point_on_A(found);
  auto& point = *new (&slot) btManifoldPoint(local_point_on_A(objects, on_A), X_WB.invXform(found.point_on_B),
                                             found.normal_on_B, found.distance);
  point.m_positionWorldOnA = on_A;
  point.m_positionWorldOnB = found.point_on_B;
  point.m_combinedFriction = shared.friction;
  point.m_combinedRestitution = shared.restitution;
  point.m_combinedRollingFriction = shared.rolling_friction;
  point.m_combinedSpinningFriction = shared.spinning_friction;
  point.m_contactPointFlags = shared.flags;
  if ((shared.flags & BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING) != 0) {
    point.m_combinedContactDamping1 = shared.damping;
    point.m_combinedContactStiffness1 = shared.stiffness;
  }
  point.m_lateralFrictionDir1 = shared.friction_direction_1;
  point.m_lateralFrictionDir2 = shared.friction_direction_2;
  point.m_partId0 = objects.a.m_partId, point.m_index0 = objects.a.m_index;
  point.m_partId1 = objects.b.m_partId, point.m_index1 = objects.b.m_index;
}

/// Which of the manifold's points each of the new ones is: by features, then by place.
class Matching {
 public:
  Matching(const ObjectPair& objects, std::span<const FoundPoint> points,
           const btPersistentManifold& manifold, const ManifoldFeatures& features)
      : count_(static_cast<int>(points.size())), old_count_(manifold.getNumContacts()) {
    old_of_.fill(kNone), new_of_.fill(kNone);
    if (features.count == old_count_) match_features(points, features);  // else someone changed it
    match_places(objects, points, manifold);
  }

  int old_of(int i) const { return old_of_[i]; }
  int new_of(int k) const { return new_of_[k]; }

 private:
  void match_features(std::span<const FoundPoint> points, const ManifoldFeatures& features) {
    for (int i = 0; i < count_; ++i)
      for (int k = 0; k < old_count_; ++k)
        if (new_of_[k] == kNone && points[i].feature_id == features.ids[k]) {
          join(i, k);
          break;
        }
  }

  void match_places(const ObjectPair& objects, std::span<const FoundPoint> points,
                    const btPersistentManifold& manifold) {
    const btScalar threshold = manifold.getContactBreakingThreshold();
    for (int i = 0; i < count_; ++i) {
      if (old_of_[i] != kNone || old_count_ == 0) continue;
      const btVector3 place = local_point_on_A(objects, point_on_A(points[i]));
      btScalar nearest = threshold * threshold;
      int best = kNone;
      for (int k = 0; k < old_count_; ++k) {
        const btScalar d = place.distance2(manifold.getContactPoint(k).m_localPointA);
        if (is_free(i, k) && d < nearest) nearest = d, best = k;
      }
      if (best != kNone) join(i, best);
    }
  }

  bool is_free(int i, int k) const { return old_of_[i] == kNone && new_of_[k] == kNone; }
  void join(int i, int k) { old_of_[i] = k, new_of_[k] = i; }

  int count_, old_count_;
  Slots old_of_, new_of_;
};

/// The part of a point that is kept from the step before.
struct Memory {
  void* user_data;
  int life_time;
  btScalar impulse, rhs, lateral_1, lateral_2;

  static Memory of(const btManifoldPoint& point) {
    return {point.m_userPersistentData,     point.m_lifeTime,
            point.m_appliedImpulse,         point.m_prevRHS,
            point.m_appliedImpulseLateral1, point.m_appliedImpulseLateral2};
  }
  void write(btManifoldPoint& point) const {
    point.m_userPersistentData = user_data;
    point.m_lifeTime = life_time;
    point.m_appliedImpulse = impulse, point.m_prevRHS = rhs;
    point.m_appliedImpulseLateral1 = lateral_1, point.m_appliedImpulseLateral2 = lateral_2;
  }
};

/// The manifold's points before they are written over.
class OldPoints {
 public:
  OldPoints(const btPersistentManifold& manifold, bool anchored) {
    const int count = manifold.getNumContacts();
    for (int k = 0; k < count; ++k) memory_[k] = Memory::of(manifold.getContactPoint(k));
    if (!anchored) return;
    whole_.emplace();
    for (int k = 0; k < count; ++k) (*whole_)[k] = manifold.getContactPoint(k);
  }

  /// Writes `found` into `slot` as what old point `k` has become.
  void carry_on(int k, const ObjectPair& objects, const Shared& shared, const FoundPoint& found, int slot,
                btPersistentManifold& manifold) const {
    btManifoldPoint& point = manifold.getContactPoint(slot);
    if (whole_) {  // the engine decides whether the anchor holds
      btManifoldPoint fresh;
      make_point(objects, shared, found, fresh);
      point = (*whole_)[k];
      manifold.replaceContactPoint(fresh, slot);
    } else {
      make_point(objects, shared, found, point);
      memory_[k].write(point);
    }
    ++point.m_lifeTime;
  }

 private:
  std::array<Memory, MANIFOLD_CACHE_SIZE> memory_;
  std::optional<std::array<btManifoldPoint, MANIFOLD_CACHE_SIZE>> whole_;
};

/// No feature of the check's has all bits set.
constexpr std::uint32_t kMiddle = 0xffffffff;

/// Of four points.
using Weights = std::array<btScalar, MANIFOLD_CACHE_SIZE>;
using Corners = std::array<FoundPoint, MANIFOLD_CACHE_SIZE>;

/// A place between the corners as their weighted mean; none for one that is not.
std::optional<Weights> weights_at(const btVector3& place, const Corners& corners) {
  const auto away = [&](int i) { return corners[i].point_on_B - corners[0].point_on_B; };
  const btVector3 way = place - corners[0].point_on_B;
  // The farthest is mostly the corner across, though not of every face: all three triangles at corner 0.
  std::array<int, 3> others{1, 2, 3};
  for (int i = 1; i < 3; ++i)
    if (away(others[i]).length2() > away(others[0]).length2()) std::swap(others[0], others[i]);
  std::sort(others.begin() + 1, others.end());
  for (const auto& [one, other] : {std::pair{0, 1}, std::pair{0, 2}, std::pair{1, 2}}) {
    const btVector3 u = away(others[one]), v = away(others[other]);
    const btScalar uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), wu = way.dot(u), wv = way.dot(v);
    const btScalar area = uu * vv - uv * uv;
    const btScalar s = wu * vv - wv * uv, t = wv * uu - wu * uv;
    if (!(area > 0) || !(s >= 0 && t >= 0 && s + t <= area)) continue;  // nor where one is not a number
    Weights weights{};
    weights[0] = 1 - (s + t) / area;
    weights[others[one]] = s / area;
    weights[others[other]] = t / area;
    return weights;
  }
  return std::nullopt;
}

/// The points found; where asked for, of four points one in their midst in place of the shallowest. The
/// solver takes it first, and one row through the place where a pair presses carries what rests on it without
/// turning it; four corners, taken one after the other, turn it to and fro, and few iterations leave some of
/// that in every step. (The engine's hull check begins at the faces' middles, too.) It begins in the middle
/// and goes half of the way to the centre of the last step's impulses at each update: the corners are left
/// little to do then, and in whole ways it swings. The points keep the first normal as long as the faces turn
/// from it by next to nothing: faces that rock by 1e-5 rad under few iterations push what rests on them to
/// one side.
class Supported {
 public:
  Supported(const ObjectPair& objects, std::span<const FoundPoint> found,
            const btPersistentManifold& manifold, const ManifoldFeatures& before, bool by_middle)
      : found_(found), has_middle_(by_middle && found.size() == MANIFOLD_CACHE_SIZE) {
    // Without a middle they stay where they are: a copy of what was just written would wait for it.
    if (!has_middle_) return;
    std::copy(found.begin(), found.end(), points_.begin());
    // Separation is linear over plane faces.
    FoundPoint middle = points_[0];
    middle.point_on_B = btVector3(0, 0, 0), middle.distance = 0, middle.feature_id = kMiddle;
    const Weights weights = weights_of_middle(objects, manifold, before);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      middle.point_on_B += weights[i] * points_[i].point_on_B;
      middle.distance += weights[i] * points_[i].distance;
    }
    const auto is_deeper = [](const FoundPoint& a, const FoundPoint& b) { return a.distance < b.distance; };
    *std::max_element(points_.begin(), points_.end(), is_deeper) = points_[0];
    points_[0] = middle;
    keep_normal(objects, manifold, before);
  }

  std::span<const FoundPoint> points() const {
    return has_middle_ ? std::span<const FoundPoint>(points_) : found_;
  }
  bool has_middle() const { return has_middle_; }

 private:
  /// What rests may shift by, between two updates or by its faces' turning: a hundredth of the breaking
  /// threshold.
  static btScalar least_way(const btPersistentManifold& manifold) {
    return btScalar(0.01) * manifold.getContactBreakingThreshold();
  }

  static bool had_middle(const btPersistentManifold& manifold, const ManifoldFeatures& before) {
    return before.count == MANIFOLD_CACHE_SIZE && before.ids[0] == kMiddle &&
           manifold.getNumContacts() == before.count;
  }

  /// Whether the middle's two places came apart along the faces since the last update by more than
  /// least_way(): friction off the middle would turn what slides.
  bool slides(const ObjectPair& objects, const btPersistentManifold& manifold) const {
    const btManifoldPoint& last = manifold.getContactPoint(0);
    const btVector3 apart = objects.a.getCollisionObject()->getWorldTransform() * last.m_localPointA -
                            objects.b.getCollisionObject()->getWorldTransform() * last.m_localPointB;
    const btVector3& n = points_[0].normal_on_B;
    const btScalar least = least_way(manifold);
    return (apart - apart.dot(n) * n).length2() > least * least;
  }

  /// Where none of the three corners kept would move by more than least_way() about the middle as the faces
  /// turned from the normal kept to the one found.
  void keep_normal(const ObjectPair& objects, const btPersistentManifold& manifold,
                   const ManifoldFeatures& before) {
    if (!had_middle(manifold, before) || slides(objects, manifold)) return;
    const btVector3& kept = manifold.getContactPoint(0).m_normalWorldOnB;
    const btScalar turn2 = (kept - points_[0].normal_on_B).length2(), least = least_way(manifold);
    for (const FoundPoint& point : points_)
      if ((point.point_on_B - points_[0].point_on_B).length2() * turn2 > least * least) return;
    for (FoundPoint& point : points_) point.normal_on_B = kept;
  }

  Weights weights_of_middle(const ObjectPair& objects, const btPersistentManifold& manifold,
                            const ManifoldFeatures& before) const {
    constexpr Weights kEqual = {btScalar(0.25), btScalar(0.25), btScalar(0.25), btScalar(0.25)};
    if (!had_middle(manifold, before) || slides(objects, manifold)) return kEqual;
    btVector3 moment(0, 0, 0);
    btScalar impulse = 0;
    for (int k = 0; k < before.count; ++k) {
      const btManifoldPoint& point = manifold.getContactPoint(k);
      moment += point.m_appliedImpulse * point.m_localPointB;
      impulse += point.m_appliedImpulse;
    }
    if (!(impulse > 0)) return kEqual;
    const btVector3 p_B = btScalar(0.5) * (moment / impulse + manifold.getContactPoint(0).m_localPointB);
    return weights_at(objects.b.getCollisionObject()->getWorldTransform() * p_B, points_).value_or(kEqual);
  }

  std::span<const FoundPoint> found_;
  bool has_middle_;
  Corners points_;  ///< with a middle
};

/// Which of `found` comes into which slot. The engine's solver takes the points in this order, and what its
/// iterations leave over falls on the places: where a leaning pair's points keep theirs, stacks bend and
/// creep to one side. Shallowest first, those of one depth as they were: what is left over rights a pair that
/// leans.
Slots deepest_last(std::span<const FoundPoint> found, const Matching& matching, int old_count) {
  Slots order;
  int count = 0;
  const auto insert = [&](int i) {
    int k = count++;
    for (; k > 0 && found[order[k - 1]].distance < found[i].distance; --k) order[k] = order[k - 1];
    order[k] = i;
  };
  for (int k = 0; k < old_count; ++k)
    if (matching.new_of(k) != kNone) insert(matching.new_of(k));
  for (int i = 0; i < static_cast<int>(found.size()); ++i)
    if (matching.old_of(i) == kNone) insert(i);
  return order;
}

/// The same for points within the solid's breadth, a margin's within its edges: there the deepest last rights
/// too much. Where the solids lean the order found, begun one place further on at each update, and after each
/// round the other way about.
Slots turned_order(std::span<const FoundPoint> found, ManifoldFeatures& features) {
  const auto is_level = [&](const FoundPoint& point) { return point.distance == found[0].distance; };
  if (!std::all_of(found.begin(), found.end(), is_level)) ++features.turns;
  const std::size_t count = found.size();
  const bool backwards = (features.turns / count) % 2 != 0;
  Slots order;
  for (std::size_t i = 0; i < count; ++i)
    order[backwards ? count - 1 - i : i] = static_cast<int>((i + features.turns) % count);
  return order;
}

bool has_margin(const btCollisionObjectWrapper& object) {
  return outer_margin(*object.getCollisionShape()) > 0.0;
}

/// Tells of the points that are gone, and makes the manifold's count `count`.
void drop_the_rest(const Matching& matching, int count, btPersistentManifold& manifold) {
  const int old_count = manifold.getNumContacts();
  for (int k = 0; k < old_count; ++k)
    if (matching.new_of(k) == kNone) manifold.clearUserCache(manifold.getContactPoint(k));
  for (int k = count; k < old_count; ++k) Memory{}.write(manifold.getContactPoint(k));
  manifold.setNumContacts(count);
}

void call_added(const ObjectPair& objects, btManifoldPoint& point) {
  if (gContactAddedCallback == nullptr) return;
  if (!has_flag(*objects.a.getCollisionObject(), *objects.b.getCollisionObject(),
                btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK))
    return;
  (*gContactAddedCallback)(point, &objects.a, point.m_partId0, point.m_index0, &objects.b, point.m_partId1,
                           point.m_index1);
}

}  // namespace

void update_manifold(const ObjectPair& objects, std::span<const FoundPoint> points,
                     btPersistentManifold& manifold, ManifoldFeatures& features, bool by_middle) {
  // The points to keep; none empties the manifold.
  const Supported supported(objects, points, manifold, features, by_middle);
  const std::span<const FoundPoint> found = supported.points();
  const int old_count = manifold.getNumContacts(), count = static_cast<int>(found.size());
  if (old_count == 0 && count == 0) {
    features.count = 0;
    return;
  }
  if (count == 0) {
    features.count = 0;
    return manifold.clearManifold();
  }
  // Found points are matched with old ones, and put in order.
  const Shared shared(*objects.a.getCollisionObject(), *objects.b.getCollisionObject(), found[0].normal_on_B);
  const Matching matching(objects, found, manifold, features);
  const bool turns = has_margin(objects.a) || has_margin(objects.b);
  const Slots order = supported.has_middle() ? Slots{0, 1, 2, 3}
                      : turns                ? turned_order(found, features)
                                             : deepest_last(found, matching, old_count);
  const OldPoints old(manifold, (shared.flags & BT_CONTACT_FLAG_FRICTION_ANCHOR) != 0);
  // Matched points carry on their impulses; the others begin anew.
  drop_the_rest(matching, count, manifold);
  for (int slot = 0; slot < count; ++slot) {
    const int i = order[slot], k = matching.old_of(i);
    if (k != kNone)
      old.carry_on(k, objects, shared, found[i], slot, manifold);
    else
      make_point(objects, shared, found[i], manifold.getContactPoint(slot));
    features.ids[slot] = found[i].feature_id;
  }
  features.count = count;

  // Bullet's callbacks, as the engine's own manifolds call them.
  for (int k = 0; k < count; ++k) call_added(objects, manifold.getContactPoint(k));
  if (gContactStartedCallback != nullptr && old_count == 0 && count > 0) gContactStartedCallback(&manifold);
  if (gContactProcessedCallback == nullptr) return;
  // The engine's callback takes its own const objects as void*.
  auto* const body0 = const_cast<btCollisionObject*>(manifold.getBody0());
  auto* const body1 = const_cast<btCollisionObject*>(manifold.getBody1());
  for (int k = 0; k < count; ++k) (*gContactProcessedCallback)(manifold.getContactPoint(k), body0, body1);
}

}  // namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE
