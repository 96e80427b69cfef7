#pragma once

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>

#include <atomic>
#include <memory>

#include "touchstone/adapters/bullet_plugin/manifold_update.hpp"
#include "touchstone/adapters/bullet_plugin/parting_face.hpp"
#include "touchstone/adapters/bullet_plugin/shape_content.hpp"
#include "touchstone/contact_core/narrowphase/pair_observer.hpp"

// Our collision algorithm, as the dispatcher creates one for each pair.

namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE {

/// State that the algorithms of a plugin share. They hold it too: a pair may outlive the plugin.
struct PluginState {
  std::shared_ptr<native::SolidStore> store;
  EngineCheck check = EngineCheck::native;
  bool middle_first = false;
  std::atomic<PairObserver*> observer = nullptr;
  std::atomic<std::uint64_t> checks = 0;
  std::atomic<std::uint64_t> refused = 0;
};

class HexahedronAlgorithm final : public btCollisionAlgorithm {
 public:
  HexahedronAlgorithm(const btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper& a,
                      const btCollisionObjectWrapper& b, std::shared_ptr<PluginState> state,
                      const native::SolidHandle& solid_a, const native::SolidHandle& solid_b);
  ~HexahedronAlgorithm() override;

  void processCollision(const btCollisionObjectWrapper* a, const btCollisionObjectWrapper* b,
                        const btDispatcherInfo& info, btManifoldResult* result) override;
  /// Always 1, the whole step, as the engine's box check says.
  btScalar calculateTimeOfImpact(btCollisionObject* a, btCollisionObject* b, const btDispatcherInfo& info,
                                 btManifoldResult* result) override;
  void getAllContactManifolds(btManifoldArray& manifolds) override;

 private:
  /// Whether two boxes without contacts are still apart, so that nothing is to be done.
  bool stays_apart(const ObjectPair& objects, const btManifoldResult& result);
  bool hold_shapes(const btCollisionShape& a, const btCollisionShape& b);
  /// Whether the points are for our own manifold alone.
  bool keeps_manifold(const btCollisionObjectWrapper& a, const btManifoldResult& result) const;
  /// The distance at which contact begins: 0, but for a pair that has just been put together, where rounding
  /// may have apart what its program placed to touch: a stack would begin with a fall, step for step.
  double touching(const ObjectPair& objects, double margins) const;
  /// Whether the contact of a pair that is apart goes on.
  bool goes_on(const native::PairAnswer& answer) const;
  std::size_t find_points(const ObjectPair& objects, const btManifoldResult& result,
                          std::span<FoundPoint, MANIFOLD_CACHE_SIZE> points);

  // What a pair that stays apart reads comes first.
  std::shared_ptr<PluginState> state_;
  btPersistentManifold* manifold_;
  const btCollisionObject* own_body0_ = nullptr;  ///< the manifold's, where that is ours; else null
  PartingFace parting_face_;
  ManifoldFeatures features_;  ///< their count is the manifold's after each update
  bool is_new_ = true;         ///< not looked at so far
  bool is_shown_ = false;      ///< since the last update: whoever has it may have put points in
  native::SolidHandle solids_[2];
};

/// Creates our algorithm for a pair of hexahedra (or, to observe, the engine's in an ObservedAlgorithm), what
/// `before` creates for the rest. Another plugin's is held: that plugin may go first.
class HexahedronCreateFunc final : public btCollisionAlgorithmCreateFunc,
                                   public std::enable_shared_from_this<HexahedronCreateFunc> {
 public:
  /// @param before what the dispatcher's table held
  HexahedronCreateFunc(std::shared_ptr<PluginState> state, btCollisionAlgorithmCreateFunc* before);

  /// The table's former entry, past the plugins that have gone.
  btCollisionAlgorithmCreateFunc* before() const;
  /// Its plugin has gone: it does what `before` does from now on.
  void retire() { is_retired_ = true; }
  btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                 const btCollisionObjectWrapper* a,
                                                 const btCollisionObjectWrapper* b) override;

 private:
  std::shared_ptr<PluginState> state_;
  btCollisionAlgorithmCreateFunc* before_;
  std::shared_ptr<const HexahedronCreateFunc> another_plugins_;  ///< before_, where it is
  bool is_retired_ = false;
};

}  // namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE
