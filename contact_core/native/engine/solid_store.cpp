#include "touchstone/contact_core/native/engine/solid_store.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <mutex>
#include <string>
#include <tuple>
#include <utility>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/narrowphase/no_geometry.hpp"
#include "touchstone/contact_core/native/check_inside.hpp"
#include "touchstone/contact_core/native/engine/pair_geometry.hpp"

namespace touchstone::native {
namespace {

/// Eight vertices that are a box about its own middle, to the bit: as such it is checked faster. Zero sides:
/// they are not.
std::array<double, 3> sides_of_box(const SolidContent& content) {
  const auto& p = content.points;
  unsigned corners = 0;
  for (const auto& vertex : p) {
    unsigned corner = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      if (std::abs(vertex[k]) != std::abs(p[0][k])) return {};
      corner |= (vertex[k] > 0.0 ? 1u : 0u) << k;
    }
    corners |= 1u << corner;
  }
  if (corners != 0xff || !(norm({p[0][0], p[0][1], p[0][2]}) < 0x1p500)) return {};
  return {2.0 * std::abs(p[0][0]), 2.0 * std::abs(p[0][1]), 2.0 * std::abs(p[0][2])};
}

std::optional<Hexahedron> make_solid(const SolidContent& content) {
  try {
    const auto& p = content.points;
    if (!content.is_box) {
      const std::array<double, 3> sides = sides_of_box(content);
      if (sides[0] > 0.0) return Hexahedron::from_size({sides[0], sides[1], sides[2]});
    }
    if (content.is_box) return Hexahedron::from_size({p[0][0], p[0][1], p[0][2]});
    std::array<Vector3, Hexahedron::kVertices> vertices;
    for (int i = 0; i < Hexahedron::kVertices; ++i) vertices[i] = {p[i][0], p[i][1], p[i][2]};
    return Hexahedron::from_vertices(vertices, WarpPolicy::accept);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

bool is_finite(const SolidContent& content) {
  for (const auto& point : content.points)
    for (const double coordinate : point)
      if (!std::isfinite(coordinate)) return false;
  return true;
}

/// Whether both are valid (is_valid_pose), by the same operations on both at once; false where these
/// overflow, too.
bool are_surely_valid(const Pose& A, const Pose& B) {
  using Both = double __attribute__((vector_size(16)));
  const auto both_of = [&](int k, int i) { return Both{A.R(k, i), B.R(k, i)}; };
  const Both x[3] = {both_of(0, 0), both_of(1, 0), both_of(2, 0)},
             y[3] = {both_of(0, 1), both_of(1, 1), both_of(2, 1)},
             z[3] = {both_of(0, 2), both_of(1, 2), both_of(2, 2)};
  const auto dot_of = [](const Both(&u)[3], const Both(&v)[3]) {
    return (u[0] * v[0] + u[1] * v[1]) + u[2] * v[2];
  };
  // Lengths, angles and handedness.
  const Both one = {1.0, 1.0}, most = {kRotationTolerance, kRotationTolerance};
  auto valid = one == one;
  for (const Both off :
       {dot_of(x, x) - one, dot_of(y, y) - one, dot_of(z, z) - one, dot_of(x, y), dot_of(x, z), dot_of(y, z)})
    valid &= (off <= most) & (off >= -most);
  const Both y_z[3] = {y[1] * z[2] - y[2] * z[1], y[2] * z[0] - y[0] * z[2], y[0] * z[1] - y[1] * z[0]};
  valid &= dot_of(x, y_z) > Both{};
  // Rotations are finite then.
  const Both p = (Both{A.p.x(), B.p.x()} + Both{A.p.y(), B.p.y()}) + Both{A.p.z(), B.p.z()};
  valid &= p - p == Both{};
  return (valid[0] & valid[1]) != 0;
}

/// The pose as the check may take it.
bool make_valid(Pose& X) {
  if (is_valid_pose(X)) return true;
  const Vector3 x = X.R.col(0), y = X.R.col(1);
  const Vector3 z = cross(x, y);
  const double length_x = norm(x), length_z = norm(z);
  if (!(length_x > 0.0) || !(length_z > 0.0)) return false;
  X.R.col(0) = x / length_x;
  X.R.col(2) = z / length_z;
  const Vector3 unit_x = X.R.col(0), unit_z = X.R.col(2);
  X.R.col(1) = cross(unit_z, unit_x);
  return is_valid_pose(X);
}

void turn_round(PairAnswer& answer) {
  answer.geometry.n_AB_W = -answer.geometry.n_AB_W;
  std::swap(answer.geometry.p_A_W, answer.geometry.p_B_W);
  for (std::int32_t i = 0; i < answer.geometry.point_count; ++i) {
    ContactPoint& point = answer.points[static_cast<std::size_t>(i)];
    std::swap(point.p_A_W, point.p_B_W);
  }
}

/// This thread's, by the place of a solid in a store: only the two of the pair at hand are ever read.
std::vector<Pose>& thread_poses() {
  thread_local std::vector<Pose> poses;
  return poses;
}

}  // namespace

/// Another narrowphase, its solids in the places that the set would have them.
struct SolidStore::Other {
  std::unique_ptr<Narrowphase> narrowphase;
  std::vector<Hexahedron> solids;
  std::mutex mutex;
  std::vector<std::unique_ptr<Narrowphase::Workspace>> idle;  // as many as have asked at one time

  static void place(std::vector<Hexahedron>& among, std::size_t first, const Hexahedron& solid) {
    while (among.size() < first + 2) among.push_back(solid);
    among[first] = among[first + 1] = solid;
  }

  void set(std::size_t first, const Hexahedron& solid) {
    if (solids.capacity() < first + 2)
      solids.reserve(2 * (first + 2));  // where it is taken nothing throws after
    const std::array twice{solid, solid};
    if (!solids.empty() && narrowphase->set_solids(static_cast<SolidIndex>(first), twice)) {
      place(solids, first, solid);
      return;
    }
    std::vector<Hexahedron> all = solids;
    place(all, first, solid);
    narrowphase->build(all);
    idle.clear();
    solids = std::move(all);
  }

  std::unique_ptr<Narrowphase::Workspace> take() {
    const std::scoped_lock lock(mutex);
    if (idle.empty()) return narrowphase->make_workspace();
    std::unique_ptr<Narrowphase::Workspace> out = std::move(idle.back());
    idle.pop_back();
    return out;
  }
  void give_back(std::unique_ptr<Narrowphase::Workspace> workspace) {
    const std::scoped_lock lock(mutex);
    idle.push_back(std::move(workspace));
  }
};

SolidStore::SolidStore() : kernels_(kernels()) {
  constexpr std::size_t kFirstPlaces = 16;
  sets_.push_back(std::make_unique<SolidSet>(make_places(kFirstPlaces)));
  set_ = sets_.back().get();
}

SolidStore::SolidStore(std::unique_ptr<Narrowphase> narrowphase) : SolidStore() {
  if (!narrowphase) throw InputError("a check inside an engine: no narrowphase");
  if (!narrowphase->capabilities().manifold)
    throw InputError("narrowphase '" + std::string(narrowphase->name()) +
                     "' has no manifolds: it cannot stand inside an engine");
  other_ = std::make_unique<Other>();
  other_->narrowphase = std::move(narrowphase);
}

SolidStore::~SolidStore() = default;

std::string_view SolidStore::name() const { return is_native() ? "native" : other_->narrowphase->name(); }

std::optional<SolidHandle> SolidStore::acquire(const SolidContent& content) {
  // No order finds what is not a number: it would be any other's equal.
  if (!is_finite(content)) return std::nullopt;
  const auto use = [](Entries::value_type& entry) {
    ++entry.second.users;
    return SolidHandle{entry.second.key, &entry.first};
  };
  {
    const std::unique_lock lock(mutex_);
    if (const auto found = entries_.find(content); found != entries_.end()) return use(*found);
  }
  const std::optional<Hexahedron> solid = make_solid(content);
  if (!solid) return std::nullopt;
  SolidSet twice = make_solid_set(std::array{*solid, *solid});
  make_placeable(twice);

  const std::unique_lock lock(mutex_);
  const auto [entry, is_new] = entries_.try_emplace(content, Entry{0, 0});
  if (!is_new) return use(*entry);
  Key& key = entry->second.key;
  key = unused_.empty() ? static_cast<Key>(entries_.size() - 1) : unused_.front();
  try {
    SolidSet& set = set_with_place(key);
    if (other_) other_->set(2 * static_cast<std::size_t>(key), *solid);
    put_in_places(set, 2 * static_cast<std::size_t>(key), twice);
  } catch (const InputError&) {
    entries_.erase(entry);
    return std::nullopt;
  } catch (...) {  // what a narrowphase of somebody's throws: no entry stays without its solid
    entries_.erase(entry);
    throw;
  }
  if (!unused_.empty()) {
    std::pop_heap(unused_.begin(), unused_.end(), std::greater<>());
    unused_.pop_back();
  }
  return use(*entry);
}

SolidSet& SolidStore::set_with_place(Key key) {
  const std::size_t places = sets_.back()->kinds.size();
  if (2 * static_cast<std::size_t>(key) + 1 < places) return *sets_.back();
  auto larger = std::make_unique<SolidSet>(make_places(2 * places));
  put_in_places(*larger, 0, *sets_.back());
  sets_.push_back(std::move(larger));
  set_.store(sets_.back().get(), std::memory_order_release);
  return *sets_.back();
}

void SolidStore::release(const SolidHandle& solid) {
  const std::unique_lock lock(mutex_);
  const auto entry = entries_.find(*solid.content);
  if (--entry->second.users > 0) return;
  unused_.push_back(entry->second.key);
  std::push_heap(unused_.begin(), unused_.end(), std::greater<>());
  entries_.erase(entry);
}

std::size_t SolidStore::size() const {
  const std::shared_lock lock(mutex_);
  return entries_.size();
}

Hexahedron SolidStore::solid(const SolidHandle& solid) const { return *make_solid(*solid.content); }

PairPlaces SolidStore::places_of(const SolidHandle& a, const SolidHandle& b) const noexcept {
  std::vector<Pose>& poses = thread_poses();
  const std::size_t places = set_.load(std::memory_order_acquire)->kinds.size();
  if (poses.size() < places) poses.resize(places);
  return {&poses[2 * a.key], &poses[2 * b.key + 1]};
}

void SolidStore::compute_manifold(const SolidHandle& a, const SolidHandle& b, const Query& query,
                                  PairAnswer& answer) const noexcept {
  if (other_) return ask_other(a, b, query, answer);
  std::vector<Pose>& poses = thread_poses();
  answer.geometry.point_count = 0;
  answer.status = PairStatus::failed;
  const SolidPair pair{2 * a.key, 2 * b.key + 1};
  Pose &X_WA = poses[pair.a], &X_WB = poses[pair.b];
  if (!are_surely_valid(X_WA, X_WB) && (!make_valid(X_WA) || !make_valid(X_WB))) return;
  NarrowphaseInput input{{&pair, 1}, poses, query};
  input.query.max_separation = std::max(query.max_separation, 0.0);
  native::compute_geometry(*set_.load(std::memory_order_acquire), kernels_, input, {&answer.status, 1},
                           {&answer.geometry, 1}, answer.points);
}

/// Pairs are asked in ascending order, and the answer is turned round where the engine's is another.
void SolidStore::ask_other(const SolidHandle& a, const SolidHandle& b, const Query& query,
                           PairAnswer& answer) const noexcept {
  const PairPlaces places = places_of(a, b);
  const Pose &X_WA = *places.X_WA, &X_WB = *places.X_WB;
  thread_local std::vector<Pose> poses;
  answer.geometry = no_geometry();
  answer.status = PairStatus::failed;
  // A backend that is not thread safe is asked by one thread at a time.
  std::shared_lock<std::shared_mutex> together(mutex_, std::defer_lock);
  std::unique_lock<std::shared_mutex> alone(mutex_, std::defer_lock);
  if (other_->narrowphase->capabilities().thread_safe)
    together.lock();
  else
    alone.lock();
  // The lower key comes first, so that both orders of a pair get the same answer.
  const bool is_turned = a.key > b.key;
  const SolidPair pair =
      is_turned ? SolidPair{2 * b.key, 2 * a.key + 1} : SolidPair{2 * a.key, 2 * b.key + 1};
  if (poses.size() < other_->solids.size()) poses.resize(other_->solids.capacity());
  poses[pair.a] = is_turned ? X_WB : X_WA;
  poses[pair.b] = is_turned ? X_WA : X_WB;
  if (!make_valid(poses[pair.a]) || !make_valid(poses[pair.b])) return;
  // Workspaces are kept between queries, which saves making them anew.
  NarrowphaseInput input{{&pair, 1}, std::span(poses).first(other_->solids.size()), query};
  input.query.max_separation = std::max(query.max_separation, 0.0);
  std::unique_ptr<Narrowphase::Workspace> workspace = other_->take();
  other_->narrowphase->evaluate(input, {{&answer.status, 1}, {&answer.geometry, 1}, answer.points},
                                *workspace);
  other_->give_back(std::move(workspace));
  // Callers know no undecided pairs: to be safe these count as overlapping.
  if (answer.status == PairStatus::unsupported) answer.status = PairStatus::failed;
  if (answer.status == PairStatus::undecided) answer.status = PairStatus::overlapping;
  if (is_turned) turn_round(answer);
}

}  // namespace touchstone::native

namespace touchstone {

std::shared_ptr<CheckInside> make_check_inside(std::unique_ptr<Narrowphase> narrowphase) {
  return std::make_shared<native::SolidStore>(std::move(narrowphase));
}

}  // namespace touchstone
