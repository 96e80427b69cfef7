#include "touchstone/adapters/ode_plugin/native_collider.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <mutex>
#include <string>
#include <vector>

#include "touchstone/adapters/ode_plugin/ode_plugin.hpp"
#include "touchstone/contact_core/narrowphase/no_geometry.hpp"

namespace touchstone {
namespace ode_plugin {
namespace {

using native::SolidHandle;
using native::SolidStore;

std::atomic<std::uint64_t> refused{0};
std::atomic<PairObserver*> current_observer{nullptr};

/// Points further apart than this [m] are no contacts: ODE's have no negative depth. With 1e-6 for corners
/// that noise lifted a stack of ten crept 24 mm in 10 s instead of 22, and a small wall ended at 0.07 m/s.
constexpr double kPointReach = 0.0;

/// How much of the depth lies between `pos` and the first box's surface; the rest lies between it and the
/// second's.
double share_of_first(int code) {
  if (code >= 1 && code <= 3) return 1.0;  // a face of the first is the reference: pos is on the second
  if (code >= 4 && code <= 6) return 0.0;
  return 0.5;
}

/// ODE's vector of four numbers, the last zero, as two halves.
struct FourOfOde {
  using Two = double __attribute__((vector_size(16)));
  Two xy, z0;

  explicit FourOfOde(const Vector3& v) : xy{v.x(), v.y()}, z0{v.z(), 0.0} {}
  void write(dReal* to) const { std::memcpy(to, &xy, sizeof xy), std::memcpy(to + 2, &z0, sizeof z0); }
};

/// @param n_21_W the contact's normal, a copy: `contact` may be anywhere
void write_contact(const ContactPoint& point, const FourOfOde n_21_W, dGeomID geom1, dGeomID geom2,
                   dContactGeom& contact) {
  FourOfOde middle(point.p_A_W);
  const FourOfOde p_B(point.p_B_W);
  middle.xy = 0.5 * (middle.xy + p_B.xy), middle.z0 = 0.5 * (middle.z0 + p_B.z0);
  middle.write(contact.pos);
  n_21_W.write(contact.normal);
  contact.depth = std::max(0.0, -point.separation);
  contact.g1 = geom1, contact.g2 = geom2;
  contact.side1 = contact.side2 = -1;
}

/// One thread's: nobody waits for another's count, as all would for one that they share.
class ThreadChecks {
 public:
  ThreadChecks() {
    Counts& counts = all();
    const std::scoped_lock lock(counts.mutex);
    counts.of_threads.push_back(&count_);
  }
  ~ThreadChecks() {
    Counts& counts = all();
    const std::scoped_lock lock(counts.mutex);
    counts.of_ended += count_.load(std::memory_order_relaxed);
    std::erase(counts.of_threads, &count_);
  }
  ThreadChecks(const ThreadChecks&) = delete;
  ThreadChecks& operator=(const ThreadChecks&) = delete;

  /// Of this thread alone.
  void add() { count_.store(count_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed); }

  static std::uint64_t sum() {
    Counts& counts = all();
    const std::scoped_lock lock(counts.mutex);
    std::uint64_t sum = counts.of_ended;
    for (const Count* const count : counts.of_threads) sum += count->load(std::memory_order_relaxed);
    return sum;
  }

 private:
  using Count = std::atomic<std::uint64_t>;
  struct Counts {
    std::mutex mutex;
    std::vector<const Count*> of_threads;
    std::uint64_t of_ended = 0;
  };
  static Counts& all() {
    static Counts& counts = *new Counts;  // never destroyed: threads may end after the program's statics
    return counts;
  }

  Count count_{0};
};

ThreadChecks& thread_checks() {
  thread_local ThreadChecks checks;
  return checks;
}

}  // namespace

std::shared_ptr<SolidStore> solid_store() {
  static const auto store = std::make_shared<SolidStore>();
  return store;
}

void write_pose(dGeomID geom, Pose& X) {
  const dReal *R = dGeomGetRotation(geom), *p = dGeomGetPosition(geom);
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) X.R(i, k) = R[4 * i + k];
  for (int k = 0; k < 3; ++k) X.p[k] = p[k];
}

Pose pose_of(dGeomID geom) {
  Pose X;
  write_pose(geom, X);
  return X;
}

native::SolidMemory& thread_memory() {
  thread_local native::SolidMemory memory(solid_store());
  return memory;
}

const SolidHandle* solid_of_box(dGeomID box, native::SolidMemory& memory) {
  dVector3 sides;
  dGeomBoxGetLengths(box, sides);
  return memory.find_box(sides);
}

const SolidHandle* solid_of_box(dGeomID box) { return solid_of_box(box, thread_memory()); }

void count_check() { thread_checks().add(); }

int refuse() {
  refused.fetch_add(1, std::memory_order_relaxed);
  return 0;
}

int collide_solids(dGeomID geom1, const SolidHandle& solid1, dGeomID geom2, const SolidHandle& solid2,
                   const SolidStore& store, int flags, dContactGeom* contacts, int skip) {
  count_check();
  const native::PairPlaces places = store.places_of(solid1, solid2);
  write_pose(geom1, *places.X_WA), write_pose(geom2, *places.X_WB);
  // One manifold answers, with as many points as ODE asks for.
  const int most = std::min(most_contacts(flags), kMaxManifoldPoints);
  const bool any_will_do = (static_cast<unsigned>(flags) & CONTACTS_UNIMPORTANT) != 0;
  native::PairAnswer answer;
  const Query query{QueryKind::manifold, 0.0, any_will_do ? kMaxManifoldPoints : most, kPointReach};
  store.compute_manifold(solid1, solid2, query, answer);
  // The observer sees the answer before it becomes ODE's contacts.
  if (PairObserver* const who = observer()) {
    const Hexahedron a = store.solid(solid1), b = store.solid(solid2);
    if (answer.status != PairStatus::failed)
      who->observe({{&a, &b},
                    {pose_of(geom1), pose_of(geom2)},
                    answer.status,
                    answer.geometry,
                    {answer.points.data(), static_cast<std::size_t>(answer.geometry.point_count)},
                    std::string(store.name()) + " inside ODE, double precision"});
  }
  // Pairs apart get no contacts; of the others also points that are slightly apart count.
  if (answer.status == PairStatus::failed) return refuse();
  if (answer.status != PairStatus::overlapping) return 0;
  const FourOfOde n_21_W(-answer.geometry.n_AB_W);
  const int found = std::min(answer.geometry.point_count, most);
  // Each is written, and by the next one again if it does not count: no predictor guesses which do.
  int count = 0;
  for (int i = 0; i < found; ++i) {
    write_contact(answer.points[i], n_21_W, geom1, geom2, contact_at(contacts, skip, count));
    count += answer.points[i].separation <= kPointReach ? 1 : 0;
  }
  return count;
}

int collide_boxes_as_ode(dGeomID box1, dGeomID box2, int flags, dContactGeom* contacts, int skip, int& code) {
  dVector3 sides1, sides2, normal;
  dGeomBoxGetLengths(box1, sides1);
  dGeomBoxGetLengths(box2, sides2);
  dReal depth;
  const int count = dBoxBox(dGeomGetPosition(box1), dGeomGetRotation(box1), sides1, dGeomGetPosition(box2),
                            dGeomGetRotation(box2), sides2, normal, &depth, &code, flags, contacts, skip);
  for (int i = 0; i < count; ++i) {
    dContactGeom& contact = contact_at(contacts, skip, i);
    for (int k = 0; k < 3; ++k) contact.normal[k] = -normal[k];
    contact.g1 = box1, contact.g2 = box2;
    contact.side1 = contact.side2 = -1;
  }
  return count;
}

PairObserver* observer() { return current_observer.load(std::memory_order_acquire); }
void set_observer(PairObserver* who) { current_observer.store(who, std::memory_order_release); }

void observe_contacts(dGeomID box1, dGeomID box2, dContactGeom* contacts, int skip, int count, int code,
                      PairObserver& who) {
  const SolidHandle *const solid1 = solid_of_box(box1), *const solid2 = solid1 ? solid_of_box(box2) : nullptr;
  if (!solid1 || !solid2) return;
  count_check();
  const std::shared_ptr<SolidStore> store = solid_store();
  const Hexahedron a = store->solid(*solid1), b = store->solid(*solid2);
  // ODE's contacts in the words of a narrowphase: the deepest is the pair's.
  std::array<ContactPoint, kMaxManifoldPoints> points;
  PairGeometry geometry = no_geometry();
  geometry.point_count = std::min(count, kMaxManifoldPoints);
  for (int i = 0; i < geometry.point_count; ++i) {
    const dContactGeom& contact = contact_at(contacts, skip, i);
    const Vector3 n_AB_W = -Vector3(contact.normal[0], contact.normal[1], contact.normal[2]);
    points[i].separation = -contact.depth;
    points[i].p_A_W = Vector3(contact.pos[0], contact.pos[1], contact.pos[2]) +
                      share_of_first(code) * contact.depth * n_AB_W;
    points[i].p_B_W = points[i].p_A_W + points[i].separation * n_AB_W;
    points[i].feature_id = 0;
    if (i > 0 && points[i].separation >= geometry.separation) continue;
    geometry.separation = points[i].separation;
    geometry.n_AB_W = n_AB_W, geometry.p_A_W = points[i].p_A_W, geometry.p_B_W = points[i].p_B_W;
  }
  who.observe({{&a, &b},
               {pose_of(box1), pose_of(box2)},
               count > 0 ? PairStatus::overlapping : PairStatus::separated,
               geometry,
               {points.data(), static_cast<std::size_t>(geometry.point_count)},
               "ODE, double precision, its own check"});
}

}  // namespace ode_plugin

std::uint64_t ode_native_checks() { return ode_plugin::ThreadChecks::sum(); }
std::uint64_t ode_native_refusals() { return ode_plugin::refused.load(); }

}  // namespace touchstone
