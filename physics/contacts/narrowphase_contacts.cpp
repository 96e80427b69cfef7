#include "touchstone/physics/contacts/narrowphase_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/physics/solver/reserved.hpp"

namespace touchstone::physics {
namespace {

constexpr std::size_t kBlock = 256;
/// Reserved by build().
constexpr std::size_t kContacts = 128;
constexpr std::size_t kPairs = 1024;

Pose pose_of(const Mover& mover, const DynamicsWorld& world) {
  if (mover.kind == Mover::Kind::body) return world.pose(mover.index);
  if (mover.kind == Mover::Kind::link) return world.link_pose(mover.index, mover.link);
  return {};
}

/// Never 0, which names nothing.
std::uint64_t key_of(const SolidPair& pair, std::uint32_t feature, std::size_t index) {
  const std::uint64_t point = feature != 0 ? feature : static_cast<std::uint32_t>(index) + 1;
  std::uint64_t key = (static_cast<std::uint64_t>(pair.a) << 32 | pair.b) * 0x9e3779b97f4a7c15;
  key ^= (point + 0x7f4a7c15) * 0xbf58476d1ce4e5b9;
  return key != 0 ? key : 1;
}

}  // namespace

NarrowphaseContacts::NarrowphaseContacts(std::unique_ptr<Broadphase> broadphase,
                                         std::unique_ptr<Narrowphase> narrowphase, double margin)
    : broadphase_(std::move(broadphase)), narrowphase_(std::move(narrowphase)), margin_(margin) {
  if (!broadphase_ || !narrowphase_) throw InputError("contacts: no broadphase or no narrowphase");
  if (!(margin > 0.0) || !std::isfinite(margin)) throw InputError("contacts: the margin must be positive");
  if (!narrowphase_->capabilities().manifold)
    throw InputError("contacts: narrowphase '" + std::string(narrowphase_->name()) + "' has no manifolds");
}

std::uint32_t NarrowphaseContacts::add(const Mover& mover, const HexahedronTree& tree, const Surface& surface,
                                       const Pose& X_MO, bool is_static) {
  if (!(surface.friction >= 0.0) || !std::isfinite(surface.friction) || !(surface.restitution >= 0.0) ||
      !(surface.restitution <= 1.0))
    throw InputError("contacts: '" + tree.name() + "': friction must be >= 0, restitution from 0 to 1");
  if (!narrowphase_->capabilities().rounded_solids)
    refuse_rounded(tree, "backend '" + std::string(narrowphase_->name()) + "'");
  parts_.push_back({mover, &tree, surface, part_of_.size(), X_MO, is_static});
  part_of_.insert(part_of_.end(), tree.solids().size(), static_cast<std::uint32_t>(parts_.size() - 1));
  return static_cast<std::uint32_t>(parts_.size() - 1);
}

void NarrowphaseContacts::set_surfaces(const SurfacePairs& pairs) {
  surfaces_ = pairs;
  was_found_ = false;
}

void NarrowphaseContacts::keep_edges() {
  keeps_edges_ = true;
  was_found_ = false;
}

void NarrowphaseContacts::exempt(const Mover& a, const Mover& b) { exempt_.emplace_back(a, b); }

void NarrowphaseContacts::exempt_parts(std::uint32_t a, std::uint32_t b) {
  exempt_parts_.emplace_back(std::min(a, b), std::max(a, b));
}

void NarrowphaseContacts::exempt_solids(SolidIndex a, SolidIndex b) {
  exempt_solids_.push_back({std::min(a, b), std::max(a, b)});
}

bool NarrowphaseContacts::is_exempt(const SolidPair& pair) const {
  if (std::binary_search(exempt_solids_.begin(), exempt_solids_.end(), pair)) return true;
  const std::uint32_t part_a = part_of_[pair.a], part_b = part_of_[pair.b];
  const Mover &a = parts_[part_a].mover, &b = parts_[part_b].mover;
  if (a == b) return true;
  const std::pair parts(std::min(part_a, part_b), std::max(part_a, part_b));
  if (std::binary_search(exempt_parts_.begin(), exempt_parts_.end(), parts)) return true;
  return std::any_of(exempt_.begin(), exempt_.end(), [&](const auto& movers) {
    return (movers.first == a && movers.second == b) || (movers.first == b && movers.second == a);
  });
}

void NarrowphaseContacts::sort_exempt() {
  std::sort(exempt_parts_.begin(), exempt_parts_.end());
  std::sort(exempt_solids_.begin(), exempt_solids_.end());
}

void NarrowphaseContacts::move_to(std::uint32_t part, const Mover& mover, const Pose& X_MO) {
  parts_[part].mover = mover, parts_[part].X_MO = X_MO;
  was_found_ = false;
}

void NarrowphaseContacts::hold_out(std::uint32_t part, bool is_out) {
  parts_[part].is_out = is_out;
  was_found_ = false;
}

void NarrowphaseContacts::reserve(std::size_t contacts, std::size_t pairs) {
  for (auto* vector : {&contacts_, &last_contacts_, &awake_contacts_}) reserve_written(*vector, contacts);
  for (auto* vector : {&origins_, &last_origins_, &awake_origins_}) reserve_written(*vector, contacts);
  for (auto* vector : {&found_, &last_found_}) reserve_written(*vector, pairs);
}

void NarrowphaseContacts::build() {
  if (parts_.empty()) throw InputError("contacts: nothing to find any between");
  sort_exempt();
  // The backends are built over the trees and solids of all parts.
  std::vector<const HexahedronTree*> trees;
  std::vector<Hexahedron> solids;
  std::vector<std::uint8_t> is_static;
  for (const Part& part : parts_) {
    trees.push_back(part.tree);
    is_static.push_back(part.is_static && part.mover.kind == Mover::Kind::ground ? 1 : 0);
    for (const PlacedHexahedron& placed : part.tree->solids()) solids.push_back(placed.solid);
  }
  BroadphaseInput input;
  input.trees = trees;
  input.margin = margin_;
  input.is_static = is_static;
  broadphase_->build(input);
  narrowphase_->build(solids);
  workspace_ = narrowphase_->make_workspace();
  // Buffers are sized for all solids and for one block of pairs.
  poses_.resize(solids.size());
  moved_.reserve(parts_.size());
  for (auto* vector : {&block_, &evaluated_}) vector->resize(kBlock);
  candidates_.reserve(kBlock);
  status_.resize(kBlock);
  geometry_.resize(kBlock);
  points_.resize(kBlock * kMaxManifoldPoints);
  path_lengths_.assign(solids.size(), 0.0);
  trial_poses_.resize(solids.size());
  is_warm_ = false;
  // Memory for contacts and pairs is reserved.
  exempt_parts_.reserve(parts_.size() * parts_.size() + exempt_parts_.size());
  reserve(kContacts, kPairs);
  was_found_ = false;
}

/// Whether the face of a solid that a contact's normal leaves by lies against another solid of its object, as
/// at a seam: nothing touches it there, but for a solid that the other one lets through. Looked at a
/// millionth of the way from the point to the middle of the face, a billionth of the solid's size outside.
bool NarrowphaseContacts::is_covered(SolidIndex solid, SolidIndex other, const Vector3& p_W,
                                     const Vector3& n_W) const {
  const Part& part = part_of(solid);
  const std::span<const PlacedHexahedron> solids = part.tree->solids();
  if (solids.size() < 2) return false;
  const Hexahedron& hexahedron = solids[solid - part.first_solid].solid;
  if (hexahedron.is_rounded()) return false;  // flat faces of rounded boxes count as free, at seams too
  const Pose& X_WS = poses_[solid];
  // The normal leaves by the face whose outward normal is nearest to it.
  int face = 0;
  double most = -2.0;
  for (int f = 0; f < 6; ++f) {
    const double along = dot(rotate(X_WS.R, hexahedron.face_plane(f).normal), n_W);
    if (along > most) most = along, face = f;
  }
  // The test point lies slightly inside the face's outline and slightly outside the solid.
  Vector3 middle = Vector3::Zero();
  for (const std::uint8_t corner : Hexahedron::kFaceVertices[static_cast<std::size_t>(face)])
    middle += 0.25 * hexahedron.vertices()[corner];
  const Vector3 q_W =
      (p_W + 0x1p-20 * (touchstone::transform(X_WS, middle) - p_W)) + (0x1p-30 * hexahedron.size()) * n_W;
  // Another solid that contains the test point covers the face, unless the pair is exempt.
  for (std::size_t i = 0; i < solids.size(); ++i) {
    if (part.first_solid + i == solid) continue;
    const auto neighbour = static_cast<SolidIndex>(part.first_solid + i);
    const Vector3 q = touchstone::transform(inverse(poses_[neighbour]), q_W);
    bool is_inside = true;
    for (int f = 0; f < 6 && is_inside; ++f)
      is_inside = solids[i].solid.face_plane(f).signed_distance(q) < 0.0;
    if (is_inside && !is_exempt({std::min(neighbour, other), std::max(neighbour, other)})) return true;
  }
  return false;
}

/// Lists the parts that moved since the last find(). @return whether any did.
bool NarrowphaseContacts::move_parts(const DynamicsWorld& world) {
  moved_.clear();
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    Part& part = parts_[i];
    const Pose X_WM = pose_of(part.mover, world);
    part.has_moved = !was_found_ || part.is_fast || !has_same_bits(X_WM, part.X_WM);
    if (!part.has_moved) continue;
    part.X_WM = X_WM;
    moved_.push_back(static_cast<std::uint32_t>(i));
    find_global_positions(*part.tree, is_same(part.X_MO, {}) ? X_WM : compose(X_WM, part.X_MO),
                          std::span(poses_).subspan(part.first_solid, part.tree->solids().size()));
  }
  return !moved_.empty();
}

/// Poses, or all that parts may come to in the step. The first time both, so that memory is there.
void NarrowphaseContacts::place_in_broadphase(bool any_fast) {
  unfollowed_ = 0;
  bool has_paths = false;
  if (any_fast || !is_warm_) {
    moved_.clear();
    for (std::size_t i = 0; i < parts_.size(); ++i) moved_.push_back(static_cast<std::uint32_t>(i));
    has_paths = broadphase_->update_paths({poses_, poses_, path_lengths_}, moved_);
    is_warm_ = true;
  }
  if (!any_fast || !has_paths) broadphase_->update(poses_, moved_);
  if (!any_fast || (has_paths && narrowphase_->capabilities().distance)) return;
  for (const Part& part : parts_) unfollowed_ += part.is_fast ? 1 : 0;
}

/// Takes over the contacts that count: all but those of sleepers that nothing awake touches.
void NarrowphaseContacts::take_awake(const DynamicsWorld& world) {
  is_touched_.assign(world.body_count(), 0);
  const auto sleeps = [&](const Mover& mover) {
    return mover.kind == Mover::Kind::body && world.is_asleep(mover.index);
  };
  for (const Contact& c : contacts_) {
    if (sleeps(c.a) && world.is_restless(c.b)) is_touched_[world.first_of_sleepers(c.a.index)] = 1;
    if (sleeps(c.b) && world.is_restless(c.a)) is_touched_[world.first_of_sleepers(c.b.index)] = 1;
  }
  const auto counts = [&](const Mover& mover) {
    return sleeps(mover) ? is_touched_[world.first_of_sleepers(mover.index)] != 0 : world.is_restless(mover);
  };
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    if (!counts(contacts_[i].a) && !counts(contacts_[i].b)) continue;
    awake_contacts_.push_back(contacts_[i]);
    awake_origins_.push_back(origins_[i]);
  }
}

std::span<const Contact> NarrowphaseContacts::show(const DynamicsWorld& world) {
  if (world.sleepers() == 0) {
    shown_origins_ = origins_;
    return contacts_;
  }
  awake_contacts_.clear();
  awake_origins_.clear();
  take_awake(world);
  shown_origins_ = awake_origins_;
  return awake_contacts_;
}

std::span<const Contact> NarrowphaseContacts::find(const DynamicsWorld& world, double h) {
  // A world that sleeps has no contacts to find.
  if (world.is_at_rest() && world.sleepers() > 0) {
    shown_origins_ = {};
    return {};
  }
  // Contacts of a deterministic narrowphase stay valid while nothing has moved.
  if (!narrowphase_->capabilities().deterministic) was_found_ = false;
  const bool any_moved = move_parts(world), any_fast = find_path_lengths(world, h);
  if (!any_moved && !any_fast && by_velocities_ == 0) return show(world);
  // The last results are kept aside, for pairs that have not moved.
  step_ = h;
  contacts_.swap(last_contacts_);
  origins_.swap(last_origins_);
  found_.swap(last_found_);
  if (!was_found_) last_found_.clear();
  contacts_.clear();
  origins_.clear();
  found_.clear();
  by_velocities_ = 0;
  undecided_ = failed_ = 0;
  // The broadphase's pairs are evaluated block by block.
  place_in_broadphase(any_fast);
  std::size_t last = 0;
  for (PairCursor cursor; !cursor.done;) {
    sort_out(broadphase_->find_pairs(cursor, block_), last);
    take_block();
  }
  // The swapped buffers get the same capacity.
  was_found_ = true;
  last_contacts_.reserve(contacts_.capacity());
  last_origins_.reserve(origins_.capacity());
  last_found_.reserve(found_.capacity());
  return show(world);
}

/// The block's pairs that count, each with its result of the last find(): pairs ascend in both.
void NarrowphaseContacts::sort_out(std::size_t count, std::size_t& last) {
  candidates_.clear();
  for (const SolidPair& pair : std::span(block_).first(count)) {
    if (is_exempt(pair)) continue;
    const Part &a = part_of(pair.a), &b = part_of(pair.b);
    if (a.is_out || b.is_out) continue;
    while (last < last_found_.size() && last_found_[last].pair < pair) ++last;
    Candidate& candidate = candidates_.emplace_back();
    candidate = {pair, nullptr};
    if (last == last_found_.size() || last_found_[last].pair != pair) continue;
    if (!a.has_moved && !b.has_moved && !a.is_fast && !b.is_fast) candidate.kept = &last_found_[last];
  }
}

void NarrowphaseContacts::take_block() {
  // The narrowphase evaluates only the pairs without a kept result.
  std::size_t count = 0;
  for (const Candidate& candidate : candidates_)
    if (candidate.kept == nullptr) evaluated_[count++] = candidate.pair;
  const Query query{QueryKind::manifold, reach_, kMaxManifoldPoints, reach_};
  narrowphase_->evaluate({std::span(evaluated_).first(count), poses_, query, {}},
                         {std::span(status_).first(count), std::span(geometry_).first(count), points_},
                         *workspace_);
  // Results are taken in the order of the pairs; kept ones are copied from the last call.
  std::size_t i = 0;
  for (const Candidate& candidate : candidates_) {
    const std::size_t first = contacts_.size();
    if (const Found* const kept = candidate.kept) {
      this->count(kept->status);
      const auto begin = static_cast<std::ptrdiff_t>(kept->first),
                 end = static_cast<std::ptrdiff_t>(kept->first + kept->count);
      contacts_.insert(contacts_.end(), last_contacts_.begin() + begin, last_contacts_.begin() + end);
      origins_.insert(origins_.end(), last_origins_.begin() + begin, last_origins_.begin() + end);
      found_.push_back({candidate.pair, kept->status, first, kept->count});
      continue;
    }
    // An evaluated pair gives its contacts; a fast, separated one may meet within the step.
    this->count(status_[i]);
    const bool is_fast = part_of(candidate.pair.a).is_fast || part_of(candidate.pair.b).is_fast;
    bool is_by_poses = true;
    if (is_fast && status_[i] == PairStatus::separated && geometry_[i].separation > margin_)
      meet_on_path(candidate.pair, geometry_[i]);
    else
      is_by_poses =
          take(candidate.pair, status_[i], geometry_[i],
               std::span(points_).subspan(i * kMaxManifoldPoints, kMaxManifoldPoints), {poses_, 0.0});
    if (is_by_poses)
      found_.push_back({candidate.pair, status_[i], first, contacts_.size() - first});
    else
      ++by_velocities_;
    ++i;
  }
}

void NarrowphaseContacts::count(PairStatus status) {
  undecided_ += status == PairStatus::undecided ? 1 : 0;
  failed_ += status == PairStatus::failed || status == PairStatus::unsupported ? 1 : 0;
}

/// @param placed where the points are. @return whether the poses alone decided
bool NarrowphaseContacts::take(const SolidPair& pair, PairStatus status, const PairGeometry& geometry,
                               std::span<const ContactPoint> points, const Placed& placed) {
  if (status == PairStatus::failed || status == PairStatus::unsupported) return true;
  if (!(geometry.separation <= margin_)) return true;
  const std::size_t count = static_cast<std::size_t>(geometry.point_count);
  const CornerTouch corner =
      keeps_edges_ ? CornerTouch::none : corner_touch(pair, geometry.n_AB_W, points.first(count), placed);
  if (corner == CornerTouch::passes) return false;
  const Part &a = part_of(pair.a), &b = part_of(pair.b);
  const Surface surface = surfaces_.between(part_of_[pair.a], a.surface, part_of_[pair.b], b.surface);
  // All of a fast pair's points that the step may close: one alone would turn it.
  const double limit = a.is_fast || b.is_fast ? margin_ + (a.travel + b.travel) : margin_;
  for (std::size_t i = 0; i < count; ++i) {
    const ContactPoint& point = points[i];
    const Vector3& n = geometry.n_AB_W;
    if (!(point.separation <= limit)) continue;
    if (is_covered(pair.a, pair.b, point.p_A_W, n) || is_covered(pair.b, pair.a, point.p_B_W, -n)) continue;
    contacts_.push_back({a.mover, b.mover, geometry.n_AB_W, point.p_A_W, point.p_B_W, surface.friction,
                         surface.restitution, key_of(pair, point.feature_id, i), radius_of(pair.a),
                         radius_of(pair.b)});
    origins_.push_back({pair, status, point.separation});
  }
  return corner == CornerTouch::none;
}

}  // namespace touchstone::physics
