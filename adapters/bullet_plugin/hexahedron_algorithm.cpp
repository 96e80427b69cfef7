#include "touchstone/adapters/bullet_plugin/hexahedron_algorithm.hpp"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <new>
#include <typeinfo>

#include "touchstone/adapters/bullet_plugin/observed_algorithm.hpp"

namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE {
namespace {

using native::SolidHandle;

/// Least cosine between the normals of two steps for one contact that goes on while apart: 45 degrees.
constexpr double kSameNormal = 0.7071;

constexpr std::ptrdiff_t kLineBytes = 64;  ///< of a cache line

std::optional<SolidHandle> acquire(native::SolidStore& store, const btCollisionShape& shape) {
  const std::optional<native::SolidContent> content = content_of(shape);
  return content ? store.acquire(*content) : std::nullopt;
}

/// Begins to fetch the manifold's end, where its bodies and count are. The engine reads them of every pair,
/// in a pile from memory: for most pairs we need them no sooner, and do not wait.
void fetch_end(const btPersistentManifold& manifold) {
  __builtin_prefetch(reinterpret_cast<const std::byte*>(&manifold + 1) - kLineBytes);
  __builtin_prefetch(reinterpret_cast<const std::byte*>(&manifold + 1) - 1);
}

/// Begins to fetch as many of the manifold's points, to be written once the check has answered. From its
/// start, which they follow: getContactPoint() asserts, where the engine's assertions are on, that it has
/// one, and whether it has is not known before its end has come.
void fetch_points(const btPersistentManifold& manifold, int count) {
  if (count <= 0) return;
  const auto* const first = reinterpret_cast<const std::byte*>(&manifold);
  const auto bytes = static_cast<std::ptrdiff_t>(sizeof(btTypedObject) +
                                                 sizeof(btManifoldPoint) * static_cast<std::size_t>(count));
  for (std::ptrdiff_t at = 0; at < bytes; at += kLineBytes) __builtin_prefetch(first + at, 1);
}

/// How far the engine's rounding of the two positions, half an ulp each, may have moved the bodies along n;
/// all ones: along any.
double position_rounding(const ObjectPair& objects, const Vector3& n) {
  const btVector3 &p_a = objects.a.getWorldTransform().getOrigin(),
                  &p_b = objects.b.getWorldTransform().getOrigin();
  double sum = 0;
  for (int k = 0; k < 3; ++k)
    sum += std::abs(n[k]) * static_cast<double>(std::max(std::abs(p_a[k]), std::abs(p_b[k])));
  return static_cast<double>(std::numeric_limits<btScalar>::epsilon()) * sum;
}

/// The points of an answer as Bullet's, the margins taken off; those beyond `limit` are left out, distances
/// within `rounding` are 0.
std::size_t write_points(const native::PairAnswer& answer, double margin_a, double margin_b, btScalar limit,
                         double rounding, std::span<FoundPoint, MANIFOLD_CACHE_SIZE> out) {
  const Vector3& n_AB_W = answer.geometry.n_AB_W;
  std::size_t count = 0;
  for (int i = 0; i < answer.geometry.point_count; ++i) {
    const ContactPoint& point = answer.points[i];
    const double separation = point.separation - (margin_a + margin_b);
    const btScalar distance = to_engine(std::abs(separation) <= rounding ? 0.0 : separation);
    if (distance > limit) continue;
    const Vector3 p_B_W = point.p_B_W - margin_b * n_AB_W;
    out[count++] = {to_engine(Vector3(-n_AB_W)), to_engine(p_B_W), distance, point.feature_id};
  }
  return count;
}

}  // namespace

HexahedronAlgorithm::HexahedronAlgorithm(const btCollisionAlgorithmConstructionInfo& info,
                                         const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                                         std::shared_ptr<PluginState> state, const SolidHandle& solid_a,
                                         const SolidHandle& solid_b)
    : btCollisionAlgorithm(info),
      state_(std::move(state)),
      manifold_(info.m_manifold),
      solids_{solid_a, solid_b} {
  const btCollisionObject *object_a = a.getCollisionObject(), *object_b = b.getCollisionObject();
  if (manifold_ == nullptr && m_dispatcher->needsCollision(object_a, object_b)) {
    manifold_ = m_dispatcher->getNewManifold(object_a, object_b);
    if (manifold_ != nullptr) own_body0_ = object_a;
  }
}

HexahedronAlgorithm::~HexahedronAlgorithm() {
  if (own_body0_ != nullptr) m_dispatcher->releaseManifold(manifold_);
  for (const SolidHandle& solid : solids_) state_->store->release(solid);
}

bool HexahedronAlgorithm::hold_shapes(const btCollisionShape& a, const btCollisionShape& b) {
  const btCollisionShape* const shapes[2] = {&a, &b};
  for (int i = 0; i < 2; ++i) {
    if (is_content_of(*solids_[i].content, *shapes[i])) continue;
    const std::optional<SolidHandle> now = acquire(*state_->store, *shapes[i]);
    if (!now) return false;
    state_->store->release(solids_[i]);
    solids_[i] = *now;
  }
  return true;
}

bool HexahedronAlgorithm::stays_apart(const ObjectPair& objects, const btManifoldResult& result) {
  const btCollisionShape &a = *objects.a.getCollisionShape(), &b = *objects.b.getCollisionShape();
  if (a.getShapeType() != BOX_SHAPE_PROXYTYPE || b.getShapeType() != BOX_SHAPE_PROXYTYPE) return false;
  if (!state_->store->is_native()) return false;  // another check is asked itself
  if (features_.count != 0 || is_shown_ || result.m_closestPointDistanceThreshold > 0 ||
      !keeps_manifold(objects.a, result) || state_->observer.load(std::memory_order_relaxed) != nullptr)
    return false;
  if (!parting_face_.parts(
          objects.a.getWorldTransform(), static_cast<const btBoxShape&>(a).getHalfExtentsWithMargin(),
          objects.b.getWorldTransform(), static_cast<const btBoxShape&>(b).getHalfExtentsWithMargin()))
    return false;
  is_new_ = false;  // apart by more than rounding
  state_->checks.fetch_add(1, std::memory_order_relaxed);
  return true;
}

bool HexahedronAlgorithm::keeps_manifold(const btCollisionObjectWrapper& a,
                                         const btManifoldResult& result) const {
  // A result of another class (contactTest's, a user's) wants the points for itself.
  return own_body0_ == a.getCollisionObject() && typeid(result) == typeid(btManifoldResult);
}

double HexahedronAlgorithm::touching(const ObjectPair& objects, double margins) const {
  constexpr double kUlps = 8.0;  // of a place that is the sum of a few lengths
  if (!is_new_) return 0.0;
  return kUlps * (position_rounding(objects, Vector3::Ones()) +
                  static_cast<double>(std::numeric_limits<btScalar>::epsilon()) * margins);
}

bool HexahedronAlgorithm::goes_on(const native::PairAnswer& answer) const {
  if (manifold_->getNumContacts() == 0) return false;
  const Vector3 before = from_engine(manifold_->getContactPoint(0).m_normalWorldOnB);
  return -dot(before, answer.geometry.n_AB_W) >= kSameNormal;
}

std::size_t HexahedronAlgorithm::find_points(const ObjectPair& objects, const btManifoldResult& result,
                                             std::span<FoundPoint, MANIFOLD_CACHE_SIZE> points) {
  const btCollisionShape &a = *objects.a.getCollisionShape(), &b = *objects.b.getCollisionShape();
  state_->checks.fetch_add(1, std::memory_order_relaxed);
  native::PairAnswer answer;
  answer.status = PairStatus::failed;
  std::size_t count = 0;
  if (hold_shapes(a, b)) {
    const double margin_a = outer_margin(a), margin_b = outer_margin(b), margins = margin_a + margin_b;
    const bool keeps = keeps_manifold(objects.a, result);
    const btScalar threshold = result.m_closestPointDistanceThreshold;
    const btScalar limit = manifold_->getContactBreakingThreshold() + threshold;
    const bool may_be_apart = !keeps || threshold > 0 || manifold_->getNumContacts() > 0;
    // Pairs that newly come near are Bullet's to find only when they touch; their points then are all that
    // Bullet would keep, so that a block that a solver tilted holds its corners from the first step on.
    const btScalar kept = keeps ? manifold_->getContactBreakingThreshold() : limit;
    const double touch = keeps ? touching(objects, margins) : 0.0;
    const Query query{QueryKind::manifold, margins + (may_be_apart ? static_cast<double>(limit) : touch),
                      MANIFOLD_CACHE_SIZE, margins + kept};
    state_->store->compute_manifold(solids_[0], from_engine(objects.a.getWorldTransform()), solids_[1],
                                    from_engine(objects.b.getWorldTransform()), query, answer);
    const double separation = answer.geometry.separation - margins;
    if (!keeps || threshold > 0 ||
        (answer.geometry.point_count > 0 && (separation <= touch || goes_on(answer))))
      count = write_points(answer, margin_a, margin_b, kept,
                           keeps ? position_rounding(objects, answer.geometry.n_AB_W) : 0.0, points);
    is_new_ = false;
  }
  if (PairObserver* const observer = state_->observer.load(std::memory_order_relaxed))
    observe_ours(objects, *state_->store, solids_, answer, *observer);
  if (answer.status == PairStatus::failed) state_->refused.fetch_add(1, std::memory_order_relaxed);
  return count;
}

void HexahedronAlgorithm::processCollision(const btCollisionObjectWrapper* a,
                                           const btCollisionObjectWrapper* b, const btDispatcherInfo&,
                                           btManifoldResult* result) {
  if (manifold_ == nullptr) return;
  fetch_end(*manifold_);
  result->setPersistentManifold(manifold_);
  const ObjectPair objects{*a, *b};
  if (stays_apart(objects, *result)) return;
  fetch_points(*manifold_, features_.count);
  is_shown_ = false;
  std::array<FoundPoint, MANIFOLD_CACHE_SIZE> points;
  const std::size_t count = find_points(objects, *result, points);
  if (keeps_manifold(*a, *result))
    return update_manifold(objects, {points.data(), count}, *manifold_, features_, state_->middle_first);
  for (const FoundPoint& point : std::span(points).first(count))
    result->addContactPoint(point.normal_on_B, point.point_on_B, point.distance);
  features_.count = ManifoldFeatures::kUnknown;
  if (own_body0_ != nullptr) result->refreshContactPoints();
}

btScalar HexahedronAlgorithm::calculateTimeOfImpact(btCollisionObject*, btCollisionObject*,
                                                    const btDispatcherInfo&, btManifoldResult*) {
  return btScalar(1);
}

void HexahedronAlgorithm::getAllContactManifolds(btManifoldArray& manifolds) {
  if (own_body0_ == nullptr) return;
  is_shown_ = true;
  manifolds.push_back(manifold_);
}

HexahedronCreateFunc::HexahedronCreateFunc(std::shared_ptr<PluginState> state,
                                           btCollisionAlgorithmCreateFunc* before)
    : state_(std::move(state)), before_(before) {
  if (const auto* const ours = dynamic_cast<const HexahedronCreateFunc*>(before))
    another_plugins_ = ours->shared_from_this();
}

btCollisionAlgorithmCreateFunc* HexahedronCreateFunc::before() const {
  return another_plugins_ && another_plugins_->is_retired_ ? another_plugins_->before() : before_;
}

btCollisionAlgorithm* HexahedronCreateFunc::CreateCollisionAlgorithm(
    btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* a,
    const btCollisionObjectWrapper* b) {
  if (is_retired_) return before()->CreateCollisionAlgorithm(info, a, b);
  const std::optional<SolidHandle> solid_a = acquire(*state_->store, *a->getCollisionShape());
  const std::optional<SolidHandle> solid_b = acquire(*state_->store, *b->getCollisionShape());
  if (!solid_a || !solid_b) {
    if (solid_a) state_->store->release(*solid_a);
    if (solid_b) state_->store->release(*solid_b);
    return before()->CreateCollisionAlgorithm(info, a, b);
  }
  if (state_->check == EngineCheck::own) {
    static_assert(sizeof(ObservedAlgorithm) <= sizeof(HexahedronAlgorithm));  // whose size the pool has
    btCollisionAlgorithm* const algorithm = before()->CreateCollisionAlgorithm(info, a, b);
    void* const memory = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(ObservedAlgorithm));
    return new (memory) ObservedAlgorithm(info, algorithm, state_, *solid_a, *solid_b);
  }
  void* const memory = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(HexahedronAlgorithm));
  return new (memory) HexahedronAlgorithm(info, *a, *b, state_, *solid_a, *solid_b);
}

}  // namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE
