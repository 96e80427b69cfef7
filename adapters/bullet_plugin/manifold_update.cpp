#include "adapters/bullet_plugin/manifold_update.hpp"

#include <utility>

namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE {
namespace {

constexpr int kNone = -1;
using Slots = std::array<int, MANIFOLD_CACHE_SIZE>;

bool has_flag(const btCollisionObject& a, const btCollisionObject& b, int flag) {
  return ((a.getCollisionFlags() | b.getCollisionFlags()) & flag) != 0;
}

/// What btManifoldResult::addContactPoint makes of a point.
btManifoldPoint make_point(const ObjectPair& objects, const FoundPoint& found) {
  const btCollisionObject& a = *objects.a.getCollisionObject();
  const btCollisionObject& b = *objects.b.getCollisionObject();
  const btVector3 point_on_A = found.point_on_B + found.normal_on_B * found.distance;
  btManifoldPoint point(a.getWorldTransform().invXform(point_on_A),
                        b.getWorldTransform().invXform(found.point_on_B), found.normal_on_B, found.distance);
  point.m_positionWorldOnA = point_on_A;
  point.m_positionWorldOnB = found.point_on_B;
  point.m_combinedFriction = btManifoldResult::calculateCombinedFriction(&a, &b);
  point.m_combinedRestitution = btManifoldResult::calculateCombinedRestitution(&a, &b);
  point.m_combinedRollingFriction = btManifoldResult::calculateCombinedRollingFriction(&a, &b);
  point.m_combinedSpinningFriction = btManifoldResult::calculateCombinedSpinningFriction(&a, &b);
  if (has_flag(a, b, btCollisionObject::CF_HAS_CONTACT_STIFFNESS_DAMPING)) {
    point.m_combinedContactDamping1 = btManifoldResult::calculateCombinedContactDamping(&a, &b);
    point.m_combinedContactStiffness1 = btManifoldResult::calculateCombinedContactStiffness(&a, &b);
    point.m_contactPointFlags |= BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING;
  }
  if (has_flag(a, b, btCollisionObject::CF_HAS_FRICTION_ANCHOR))
    point.m_contactPointFlags |= BT_CONTACT_FLAG_FRICTION_ANCHOR;
  btPlaneSpace1(point.m_normalWorldOnB, point.m_lateralFrictionDir1, point.m_lateralFrictionDir2);
  point.m_partId0 = objects.a.m_partId, point.m_index0 = objects.a.m_index;
  point.m_partId1 = objects.b.m_partId, point.m_index1 = objects.b.m_index;
  return point;
}

/// Which of the manifold's points each of the new ones is: by features, then by place.
class Matching {
 public:
  Matching(std::span<const btManifoldPoint> points, std::span<const std::uint32_t> ids,
           const btPersistentManifold& manifold, const ManifoldFeatures& features)
      : count_(static_cast<int>(points.size())) {
    old_of_.fill(kNone), new_of_.fill(kNone);
    const int old_count = manifold.getNumContacts();
    if (features.count == old_count) {  // else someone cleared or changed it
      for (int i = 0; i < count_; ++i)
        for (int k = 0; k < old_count; ++k)
          if (is_free(i, k) && ids[i] == features.ids[k]) join(i, k);
    }
    const btScalar threshold = manifold.getContactBreakingThreshold();
    for (int i = 0; i < count_; ++i) {
      btScalar nearest = threshold * threshold;
      int best = kNone;
      for (int k = 0; k < old_count; ++k) {
        const btScalar d = points[i].m_localPointA.distance2(manifold.getContactPoint(k).m_localPointA);
        if (is_free(i, k) && d < nearest) nearest = d, best = k;
      }
      if (best != kNone) join(i, best);
    }
  }

  int old_of(int i) const { return old_of_[i]; }
  int new_of(int k) const { return new_of_[k]; }

 private:
  bool is_free(int i, int k) const { return old_of_[i] == kNone && new_of_[k] == kNone; }
  void join(int i, int k) { old_of_[i] = k, new_of_[k] = i; }

  int count_;
  Slots old_of_, new_of_;
};

void call_added(const ObjectPair& objects, btManifoldPoint& point) {
  if (gContactAddedCallback == nullptr) return;
  if (!has_flag(*objects.a.getCollisionObject(), *objects.b.getCollisionObject(),
                btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK))
    return;
  (*gContactAddedCallback)(point, &objects.a, point.m_partId0, point.m_index0, &objects.b, point.m_partId1,
                           point.m_index1);
}

/// Writes a point over one whose features are gone.
void overwrite(const btManifoldPoint& point, int slot, btPersistentManifold& manifold) {
  btManifoldPoint& old = manifold.getContactPoint(slot);
  manifold.clearUserCache(old);
  old = point;
}

/// Writes a point over the one it continues.
void carry_on(const btManifoldPoint& point, int slot, btPersistentManifold& manifold) {
  manifold.replaceContactPoint(point, slot);
  ++manifold.getContactPoint(slot).m_lifeTime;
}

}  // namespace

void update_manifold(const ObjectPair& objects, std::span<const FoundPoint> found,
                     btPersistentManifold& manifold, ManifoldFeatures& features) {
  const int old_count = manifold.getNumContacts(), count = static_cast<int>(found.size());
  if (old_count == 0 && count == 0) {
    features.count = 0;
    return;
  }
  std::array<btManifoldPoint, MANIFOLD_CACHE_SIZE> points;
  std::array<std::uint32_t, MANIFOLD_CACHE_SIZE> ids{};
  for (int i = 0; i < count; ++i) points[i] = make_point(objects, found[i]), ids[i] = found[i].feature_id;

  const Matching matching({points.data(), found.size()}, ids, manifold, features);
  Slots new_in;  // which of `found` is in each of the manifold's slots
  new_in.fill(kNone);
  for (int k = 0; k < old_count; ++k) {
    new_in[k] = matching.new_of(k);
    if (new_in[k] != kNone) carry_on(points[new_in[k]], k, manifold);
  }
  for (int i = 0, k = 0; i < count; ++i) {
    if (matching.old_of(i) != kNone) continue;
    while (k < old_count && new_in[k] != kNone) ++k;
    const int slot = k < old_count ? k : manifold.addManifoldPoint(points[i]);
    if (k < old_count) overwrite(points[i], slot, manifold);
    new_in[slot] = i;
  }
  for (int k = old_count - 1; k >= 0; --k) {
    if (new_in[k] != kNone) continue;
    new_in[k] = new_in[manifold.getNumContacts() - 1];  // the engine fills the gap with its last
    manifold.removeContactPoint(k);
  }
  features.count = count;
  for (int k = 0; k < count; ++k) features.ids[k] = ids[new_in[k]];

  for (int k = 0; k < count; ++k) call_added(objects, manifold.getContactPoint(k));
  if (gContactStartedCallback != nullptr && old_count == 0 && count > 0) gContactStartedCallback(&manifold);
  if (gContactProcessedCallback == nullptr) return;
  // The engine's callback takes its own const objects as void*.
  auto* const body0 = const_cast<btCollisionObject*>(manifold.getBody0());
  auto* const body1 = const_cast<btCollisionObject*>(manifold.getBody1());
  for (int k = 0; k < count; ++k) (*gContactProcessedCallback)(manifold.getContactPoint(k), body0, body1);
}

}  // namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE
