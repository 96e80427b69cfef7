#include "touchstone/adapters/mujoco_plugin/mujoco_plugin.hpp"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <numeric>
#include <string>

#include "touchstone/adapters/mujoco/engine.hpp"
#include "touchstone/adapters/mujoco_plugin/geom_solid.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

using namespace mujoco_plugin;
using mujoco::EngineContact;
using mujoco::normal_of;
using native::SolidHandle;

static_assert(kMaxManifoldPoints <= mjMAXCONPAIR);

constexpr int kTypes[3][2] = {
    {mjGEOM_BOX, mjGEOM_BOX}, {mjGEOM_BOX, mjGEOM_MESH}, {mjGEOM_MESH, mjGEOM_MESH}};

/// State that all live overrides share.
struct Overrides {
  std::mutex mutex;
  int count = 0;
  MujocoOverride::Options options;
  std::shared_ptr<native::SolidStore> store;  // whose answers stand inside
  mjfCollision before[3] = {};
  std::atomic<std::uint64_t> checks{0};
};

Overrides& overrides() {
  static Overrides shared;
  return shared;
}

mjfCollision before(const mjModel& model, int geom1, int geom2) {
  return overrides()
      .before[(model.geom_type[geom1] == mjGEOM_MESH) + (model.geom_type[geom2] == mjGEOM_MESH)];
}

struct SolidPairHandles {
  const SolidHandle *first, *second;

  SolidPairHandles(const std::shared_ptr<native::SolidStore>& store, const mjModel& model, int geom1,
                   int geom2)
      : first(solid_of(store, model, geom1)), second(first ? solid_of(store, model, geom2) : nullptr) {}
  bool known() const { return first != nullptr && second != nullptr; }
};

void tell(PairObserver& observer, const SolidPairHandles& pair, const Pose& X_1, const Pose& X_2,
          PairStatus status, const PairGeometry& geometry, std::span<const ContactPoint> points,
          std::string_view by) {
  const native::SolidStore& store = *overrides().store;
  const Hexahedron a = store.solid(*pair.first), b = store.solid(*pair.second);
  observer.observe({{&a, &b}, {X_1, X_2}, status, geometry, points, by});
}

void write_contact(const ContactPoint& point, const Vector3& n_12_W, EngineContact& contact) {
  contact = {};  // the engine makes the axes that are zero
  contact.dist = point.separation;
  for (int k = 0; k < 3; ++k) {
    contact.pos[k] = 0.5 * (point.p_A_W[k] + point.p_B_W[k]);
    normal_of(contact)[k] = n_12_W[k];
  }
}

/// mjfCollision, whose mjData is const in some versions.
template <class Data>
int collide(const mjModel* model, Data* data, EngineContact* contacts, int geom1, int geom2, mjtNum margin) {
  Overrides& shared = overrides();
  const SolidPairHandles pair(shared.store, *model, geom1, geom2);
  if (!pair.known()) return before(*model, geom1, geom2)(model, data, contacts, geom1, geom2, margin);
  shared.checks.fetch_add(1, std::memory_order_relaxed);
  const Pose X_1 = pose_of(*data, geom1), X_2 = pose_of(*data, geom2);
  native::PairAnswer answer;
  const int most =
      std::min(shared.options.most_contacts, mujoco::places_for_contacts(model, geom1, geom2, margin));
  const Query query{QueryKind::manifold, margin, most, margin};
  shared.store->compute_manifold(*pair.first, X_1, *pair.second, X_2, query, answer);
  if (shared.options.observer != nullptr && answer.status != PairStatus::failed)
    tell(*shared.options.observer, pair, X_1, X_2, answer.status, answer.geometry,
         {answer.points.data(), static_cast<std::size_t>(answer.geometry.point_count)},
         std::string(shared.store->name()) + " inside MuJoCo");
  int count = 0;
  for (int i = 0; i < answer.geometry.point_count; ++i)
    if (answer.points[i].separation <= margin)
      write_contact(answer.points[i], answer.geometry.n_AB_W, contacts[count++]);
  return count;
}

/// The collider that was there before, observed.
template <class Data>
int collide_observed(const mjModel* model, Data* data, EngineContact* contacts, int geom1, int geom2,
                     mjtNum margin) {
  // The engine's own check answers, and the observer only looks on.
  const int count = before(*model, geom1, geom2)(model, data, contacts, geom1, geom2, margin);
  Overrides& shared = overrides();
  const SolidPairHandles pair(shared.store, *model, geom1, geom2);
  if (!pair.known() || shared.options.observer == nullptr) return count;
  shared.checks.fetch_add(1, std::memory_order_relaxed);
  // The pair's geometry is that of the deepest point, which comes first.
  std::array<int, mjMAXCONPAIR> order{};
  std::iota(order.begin(), order.begin() + count, 0);
  std::stable_sort(order.begin(), order.begin() + count,
                   [&](int i, int k) { return contacts[i].dist < contacts[k].dist; });
  // Points in contact are reported as a manifold of ours.
  const Vector3 unknown = Vector3::Constant(kNaN);
  PairGeometry geometry{kNaN, unknown, unknown, unknown, 0};
  std::array<ContactPoint, kMaxManifoldPoints> points;
  for (int i = 0; i < std::min(count, kMaxManifoldPoints) && contacts[order[i]].dist <= 0.0; ++i) {
    const EngineContact& contact = contacts[order[i]];
    const auto& normal = normal_of(contact);
    const Vector3 n_12_W(normal[0], normal[1], normal[2]);
    const Vector3 middle(contact.pos[0], contact.pos[1], contact.pos[2]);
    points[i] = {middle - 0.5 * contact.dist * n_12_W, middle + 0.5 * contact.dist * n_12_W, contact.dist, 0};
    if (i == 0) geometry = {contact.dist, n_12_W, points[0].p_A_W, points[0].p_B_W, 0};
    geometry.point_count = i + 1;
  }
  tell(*shared.options.observer, pair, pose_of(*data, geom1), pose_of(*data, geom2),
       geometry.point_count > 0 ? PairStatus::overlapping : PairStatus::separated, geometry,
       {points.data(), static_cast<std::size_t>(geometry.point_count)}, "MuJoCo, its own check");
  return count;
}

mjfCollision& entry(int i) { return mjCOLLISIONFUNC[kTypes[i][0]][kTypes[i][1]]; }

void check_options(const MujocoOverride::Options& options) {
  mujoco::require_version();
  if (options.most_contacts < 1 || options.most_contacts > kMaxManifoldPoints)
    throw InputError("MuJoCo: most_contacts is " + std::to_string(options.most_contacts) + ", must be 1 to " +
                     std::to_string(kMaxManifoldPoints));
}

}  // namespace

MujocoOverride::MujocoOverride(const Options& options) {
  check_options(options);
  Overrides& shared = overrides();
  const std::scoped_lock lock(shared.mutex);
  const std::shared_ptr<native::SolidStore> wanted = options.inside ? options.inside : solid_store();
  if (shared.count > 0 && options.check == EngineCheck::native && wanted != shared.store)
    throw InputError("MuJoCo: another override lives, with check '" + std::string(shared.store->name()) +
                     "'");
  if (shared.count++ > 0) return;
  mujoco::own_collision_functions();  // for the backend, which asks the engine all the same
  shared.options = options;
  shared.store = wanted;
  for (int i = 0; i < 3; ++i) {
    shared.before[i] = entry(i);
    if (options.check == EngineCheck::native)
      entry(i) = &collide;
    else
      entry(i) = &collide_observed;
  }
}

MujocoOverride::~MujocoOverride() {
  Overrides& shared = overrides();
  const std::scoped_lock lock(shared.mutex);
  if (--shared.count > 0) return;
  shared.options = {};
  shared.store.reset();
  for (int i = 0; i < 3; ++i) entry(i) = shared.before[i];
}

std::uint64_t mujoco_native_checks() { return overrides().checks.load(); }

}  // namespace touchstone
