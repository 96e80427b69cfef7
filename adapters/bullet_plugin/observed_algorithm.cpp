#include "touchstone/adapters/bullet_plugin/observed_algorithm.hpp"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>

#include <algorithm>
#include <string>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/narrowphase/no_geometry.hpp"

namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE {
namespace {

void tell(const ObjectPair& objects, const native::SolidStore& store, const native::SolidHandle (&solids)[2],
          PairStatus status, const PairGeometry& geometry, std::span<const ContactPoint> points,
          std::string_view by, PairObserver& observer) {
  const Hexahedron a = store.solid(solids[0]), b = store.solid(solids[1]);
  observer.observe({{&a, &b},
                    {from_engine(objects.a.getWorldTransform()), from_engine(objects.b.getWorldTransform())},
                    status,
                    geometry,
                    points,
                    by});
}

/// A manifold's points as ours, for the sharp solids: the margins put back.
class OwnAnswer {
 public:
  OwnAnswer(const btPersistentManifold& manifold, bool swapped, double margin_a, double margin_b) {
    for (int i = 0; i < manifold.getNumContacts(); ++i) {
      const btManifoldPoint& point = manifold.getContactPoint(i);
      const Vector3 n_on_B = from_engine(point.m_normalWorldOnB);
      const Vector3 n_AB_W = swapped ? n_on_B : Vector3(-n_on_B);
      const Vector3 p_0 = from_engine(point.getPositionWorldOnA()),
                    p_1 = from_engine(point.getPositionWorldOnB());
      ContactPoint& out = points_[i];
      out.separation = point.getDistance() + (margin_a + margin_b);
      out.p_A_W = (swapped ? p_1 : p_0) - margin_a * n_AB_W;
      out.p_B_W = (swapped ? p_0 : p_1) + margin_b * n_AB_W;
      out.feature_id = 0;
      if (i > 0 && out.separation >= geometry_.separation) continue;
      geometry_ = {out.separation, n_AB_W, out.p_A_W, out.p_B_W, 0};
    }
    geometry_.point_count = manifold.getNumContacts();
  }

  const PairGeometry& geometry() const { return geometry_; }
  std::span<const ContactPoint> points() const {
    return {points_.data(), static_cast<std::size_t>(geometry_.point_count)};
  }

 private:
  std::array<ContactPoint, MANIFOLD_CACHE_SIZE> points_{};
  PairGeometry geometry_ = no_geometry();
};

constexpr std::string_view kOwn =
    kDouble ? "Bullet, double precision, its own check" : "Bullet, single precision, its own check";
constexpr std::string_view kInside =
    kDouble ? " inside Bullet, double precision" : " inside Bullet, single precision";

}  // namespace

ObservedAlgorithm::~ObservedAlgorithm() {
  if (algorithm_ != nullptr) {
    algorithm_->~btCollisionAlgorithm();
    m_dispatcher->freeCollisionAlgorithm(algorithm_);
  }
  for (const native::SolidHandle& solid : solids_) state_->store->release(solid);
}

void ObservedAlgorithm::processCollision(const btCollisionObjectWrapper* a, const btCollisionObjectWrapper* b,
                                         const btDispatcherInfo& info, btManifoldResult* result) {
  if (algorithm_ == nullptr) return;
  algorithm_->processCollision(a, b, info, result);
  PairObserver* const observer = state_->observer.load(std::memory_order_relaxed);
  const btCollisionShape &shape_a = *a->getCollisionShape(), &shape_b = *b->getCollisionShape();
  const btPersistentManifold* const manifold = result->getPersistentManifold();
  if (observer == nullptr || manifold == nullptr || !is_content_of(*solids_[0].content, shape_a) ||
      !is_content_of(*solids_[1].content, shape_b))
    return;
  state_->checks.fetch_add(1, std::memory_order_relaxed);
  const bool swapped = manifold->getBody0() != a->getCollisionObject();
  const OwnAnswer answer(*manifold, swapped, outer_margin(shape_a), outer_margin(shape_b));
  const bool contact = answer.geometry().point_count > 0 && answer.geometry().separation <= 0.0;
  tell({*a, *b}, *state_->store, solids_, contact ? PairStatus::overlapping : PairStatus::separated,
       contact ? answer.geometry() : no_geometry(), contact ? answer.points() : std::span<ContactPoint>{},
       kOwn, *observer);
}

void observe_ours(const ObjectPair& objects, const native::SolidStore& store,
                  const native::SolidHandle (&solids)[2], const native::PairAnswer& answer,
                  PairObserver& observer) {
  if (answer.status == PairStatus::failed) return;
  const bool known = answer.geometry.separation < kInfinity;
  tell(objects, store, solids, answer.status, known ? answer.geometry : no_geometry(),
       {answer.points.data(), static_cast<std::size_t>(answer.geometry.point_count)},
       std::string(store.name()).append(kInside), observer);
}

}  // namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE
