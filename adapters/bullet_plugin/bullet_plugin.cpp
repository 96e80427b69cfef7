#include "touchstone/adapters/bullet_plugin/bullet_plugin.hpp"

#include <BulletCollision/CollisionDispatch/btCollisionConfiguration.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <LinearMath/btPoolAllocator.h>

#include <string>
#include <vector>

#include "touchstone/adapters/bullet_plugin/hexahedron_algorithm.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

using namespace TOUCHSTONE_BULLET_NAMESPACE;

/// The dispatcher's tables, which it lets derived classes read and everyone write.
struct Tables : btCollisionDispatcher {
  static auto contact_points() { return &Tables::m_doubleDispatchContactPoints; }
  static auto closest_points() { return &Tables::m_doubleDispatchClosestPoints; }
  static auto pool() { return &Tables::m_collisionAlgorithmPoolAllocator; }
};

void check_pool(btCollisionDispatcher& dispatcher) {
  const auto element = static_cast<std::size_t>((dispatcher.*Tables::pool())->getElementSize());
  constexpr std::size_t kNeeded = sizeof(HexahedronAlgorithm);
  if (element >= kNeeded) return;
  throw InputError("Bullet: the dispatcher's pool has elements of " + std::to_string(element) +
                   " bytes, our algorithm needs " + std::to_string(kNeeded) +
                   " (btDefaultCollisionConstructionInfo::m_customCollisionAlgorithmMaxElementSize)");
}

}  // namespace

class BulletPlugin::Registration {
 public:
  Registration(btCollisionDispatcher& dispatcher, const Options& options)
      : dispatcher_(dispatcher), state_(std::make_shared<PluginState>()) {
    check_pool(dispatcher);
    state_->check = options.check;
    state_->middle_first = options.middle_first;
    state_->observer = options.observer;
    state_->store = options.inside ? options.inside : std::make_shared<native::SolidStore>();
    constexpr int kTypes[2] = {BOX_SHAPE_PROXYTYPE, CONVEX_HULL_SHAPE_PROXYTYPE};
    for (const int a : kTypes) {
      for (const int b : kTypes) {
        entries_.push_back({a, b, std::make_shared<HexahedronCreateFunc>(state_, contacts(a, b)),
                            std::make_shared<HexahedronCreateFunc>(state_, closest(a, b))});
      }
    }
    for (const Entry& entry : entries_) {
      dispatcher_.registerCollisionCreateFunc(entry.a, entry.b, entry.contacts.get());
      dispatcher_.registerClosestPointsCreateFunc(entry.a, entry.b, entry.closest_points.get());
    }
  }

  ~Registration() {
    state_->observer = nullptr;
    for (const auto& [a, b, contacts_entry, closest_entry] : entries_) {
      contacts_entry->retire(), closest_entry->retire();
      if (contacts(a, b) == contacts_entry.get())
        dispatcher_.registerCollisionCreateFunc(a, b, contacts_entry->before());
      if (closest(a, b) == closest_entry.get())
        dispatcher_.registerClosestPointsCreateFunc(a, b, closest_entry->before());
    }
  }

  Registration(const Registration&) = delete;
  Registration& operator=(const Registration&) = delete;

  const PluginState& state() const { return *state_; }

 private:
  struct Entry {
    int a, b;  ///< shape types
    std::shared_ptr<HexahedronCreateFunc> contacts, closest_points;
  };

  btCollisionAlgorithmCreateFunc* contacts(int a, int b) const {
    return (dispatcher_.*Tables::contact_points())[a][b];
  }
  btCollisionAlgorithmCreateFunc* closest(int a, int b) const {
    return (dispatcher_.*Tables::closest_points())[a][b];
  }

  btCollisionDispatcher& dispatcher_;
  std::shared_ptr<PluginState> state_;
  std::vector<Entry> entries_;
};

BulletPlugin::BulletPlugin(btCollisionDispatcher& dispatcher, const Options& options)
    : registration_(std::make_unique<Registration>(dispatcher, options)) {}
BulletPlugin::~BulletPlugin() = default;

BulletPlugin::Statistics BulletPlugin::statistics() const {
  const PluginState& state = registration_->state();
  return {state.checks.load(), state.refused.load()};
}

}  // namespace touchstone
