#include "touchstone/adapters/dart_plugin/dart_plugin.hpp"

#include <array>
#include <atomic>
#include <dart/collision/CollisionFilter.hpp>
#include <dart/collision/CollisionGroup.hpp>
#include <dart/collision/fcl/FCLCollisionDetector.hpp>
#include <string>
#include <vector>

#include "touchstone/adapters/dart_plugin/object_solid.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

using dart::collision::CollisionGroup;
using dart::collision::CollisionObject;
using dart::collision::CollisionOption;
using dart::collision::CollisionResult;
using native::SolidHandle;

std::atomic<std::uint64_t>& checks() {
  static std::atomic<std::uint64_t> count{0};
  return count;
}

/// Objects, not their solids: a thread holds those of the last 1024 shapes only.
struct ObjectPair {
  CollisionObject *first, *second;
};

/// Keeps from FCL the pairs that are ours, and writes them down.
class OursApart final : public dart::collision::CollisionFilter {
 public:
  bool ignoresCollision(const CollisionObject* first, const CollisionObject* second) const override {
    if (users != nullptr && users->ignoresCollision(first, second)) return true;
    if (!dart_plugin::solid_of(*first) || !dart_plugin::solid_of(*second)) return false;
    // Contacts name objects that are not const; the filter is asked with const ones.
    pairs.push_back({const_cast<CollisionObject*>(first), const_cast<CollisionObject*>(second)});
    return true;
  }

  const dart::collision::CollisionFilter* users = nullptr;
  mutable std::vector<ObjectPair> pairs;
};

dart::collision::Contact to_contact(const ObjectPair& pair, const ContactPoint& point,
                                    const Vector3& n_12_W) {
  dart::collision::Contact contact;
  contact.collisionObject1 = pair.first, contact.collisionObject2 = pair.second;
  for (int k = 0; k < 3; ++k) {
    contact.point[k] = 0.5 * (point.p_A_W[k] + point.p_B_W[k]);
    contact.normal[k] = -n_12_W[k];
  }
  contact.penetrationDepth = -point.separation;
  return contact;
}

class DartDetector final : public dart::collision::FCLCollisionDetector {
 public:
  explicit DartDetector(const DartOptions& options) : options_(options) {}

  std::shared_ptr<CollisionDetector> cloneWithoutCollisionObjects() const override {
    return std::make_shared<DartDetector>(options_);
  }
  const std::string& getType() const override {
    static const std::string type = "touchstone";
    return type;
  }

  bool collide(CollisionGroup* group, const CollisionOption& option, CollisionResult* result) override {
    return collide_apart(option, result, [&](const CollisionOption& theirs) {
      return FCLCollisionDetector::collide(group, theirs, result);
    });
  }
  bool collide(CollisionGroup* group1, CollisionGroup* group2, const CollisionOption& option,
               CollisionResult* result) override {
    return collide_apart(option, result, [&](const CollisionOption& theirs) {
      return FCLCollisionDetector::collide(group1, group2, theirs, result);
    });
  }

 private:
  template <class TheirCheck>
  bool collide_apart(const CollisionOption& option, CollisionResult* result, const TheirCheck& check) {
    filter_->users = option.collisionFilter.get();
    filter_->pairs.clear();
    CollisionOption theirs = option;
    theirs.collisionFilter = filter_;
    const bool they_collide = check(theirs);
    const bool first_is_enough = result == nullptr || !option.enableContact;
    return (they_collide && first_is_enough) || check_ours(option, result, first_is_enough) || they_collide;
  }

  bool check_ours(const CollisionOption& option, CollisionResult* result, bool first_is_enough) {
    bool any = false;
    for (const ObjectPair& pair : filter_->pairs) {
      if (result != nullptr && result->getNumContacts() >= option.maxNumContacts) break;
      if (check_pair(pair, option, result)) any = true;
      if (any && first_is_enough) break;
    }
    return any;
  }

  bool check_pair(const ObjectPair& pair, const CollisionOption& option, CollisionResult* result) {
    checks().fetch_add(1, std::memory_order_relaxed);
    const std::array<SolidHandle, 2> solids = {*dart_plugin::solid_of(*pair.first),
                                               *dart_plugin::solid_of(*pair.second)};
    const Pose X_1 = dart_plugin::pose_of(*pair.first), X_2 = dart_plugin::pose_of(*pair.second);
    const Query query{QueryKind::manifold, 0.0, options_.most_contacts, 0.0};
    native::PairAnswer answer;
    dart_plugin::solid_store().compute_manifold(solids[0], X_1, solids[1], X_2, query, answer);
    if (options_.observer != nullptr && answer.status != PairStatus::failed)
      observe(solids, X_1, X_2, answer);
    if (answer.status != PairStatus::overlapping) return false;
    for (int i = 0; result != nullptr && i < answer.geometry.point_count; ++i) {
      if (result->getNumContacts() >= option.maxNumContacts) break;
      result->addContact(to_contact(pair, answer.points[i], answer.geometry.n_AB_W));
    }
    return true;
  }

  void observe(const std::array<SolidHandle, 2>& solids, const Pose& X_1, const Pose& X_2,
               const native::PairAnswer& answer) {
    const native::SolidStore& store = dart_plugin::solid_store();
    const Hexahedron a = store.solid(solids[0]), b = store.solid(solids[1]);
    options_.observer->observe({{&a, &b},
                                {X_1, X_2},
                                answer.status,
                                answer.geometry,
                                {answer.points.data(), static_cast<std::size_t>(answer.geometry.point_count)},
                                "native inside DART"});
  }

  DartOptions options_;
  std::shared_ptr<OursApart> filter_ = std::make_shared<OursApart>();
};

}  // namespace

std::shared_ptr<dart::collision::CollisionDetector> make_dart_detector(const DartOptions& options) {
  if (options.most_contacts < 1 || options.most_contacts > kMaxManifoldPoints)
    throw InputError("DART: most_contacts is " + std::to_string(options.most_contacts) + ", must be 1 to " +
                     std::to_string(kMaxManifoldPoints));
  return std::make_shared<DartDetector>(options);
}

void register_dart_detector() {
  auto& factory = *dart::collision::CollisionDetector::getFactory();
  if (!factory.canCreate("touchstone"))
    factory.registerCreator("touchstone", [] { return make_dart_detector(); });
}

std::uint64_t dart_native_checks() { return checks().load(); }

}  // namespace touchstone
