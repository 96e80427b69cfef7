#pragma once

#include "touchstone/adapters/bullet_plugin/hexahedron_algorithm.hpp"

// Calls of a pair observer.

namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE {

/// The engine's own algorithm of a pair, watched.
class ObservedAlgorithm final : public btCollisionAlgorithm {
 public:
  /// @param algorithm the engine's own; may be null; of the dispatcher's memory, as it creates algorithms;
  /// this ends it.
  ObservedAlgorithm(const btCollisionAlgorithmConstructionInfo& info, btCollisionAlgorithm* algorithm,
                    std::shared_ptr<PluginState> state, const native::SolidHandle& solid_a,
                    const native::SolidHandle& solid_b)
      : btCollisionAlgorithm(info),
        algorithm_(algorithm),
        state_(std::move(state)),
        solids_{solid_a, solid_b} {}
  ~ObservedAlgorithm() override;

  void processCollision(const btCollisionObjectWrapper* a, const btCollisionObjectWrapper* b,
                        const btDispatcherInfo& info, btManifoldResult* result) override;
  btScalar calculateTimeOfImpact(btCollisionObject* a, btCollisionObject* b, const btDispatcherInfo& info,
                                 btManifoldResult* result) override {
    return algorithm_ == nullptr ? btScalar(1) : algorithm_->calculateTimeOfImpact(a, b, info, result);
  }
  void getAllContactManifolds(btManifoldArray& manifolds) override {
    if (algorithm_ != nullptr) algorithm_->getAllContactManifolds(manifolds);
  }

 private:
  btCollisionAlgorithm* algorithm_;
  std::shared_ptr<PluginState> state_;
  native::SolidHandle solids_[2];
};

/// Tells of our own answer.
void observe_ours(const ObjectPair& objects, const native::SolidStore& store,
                  const native::SolidHandle (&solids)[2], const native::PairAnswer& answer,
                  PairObserver& observer);

}  // namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE
