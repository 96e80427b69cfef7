#include "physics/narrowphase_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "contact_core/input_error.hpp"

namespace touchstone::physics {
namespace {

constexpr std::size_t kBlock = 256;

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

std::uint32_t NarrowphaseContacts::add(const Mover& mover, const HexahedronTree& tree,
                                       const Surface& surface) {
  if (!(surface.friction >= 0.0) || !std::isfinite(surface.friction) || !(surface.restitution >= 0.0) ||
      !(surface.restitution <= 1.0))
    throw InputError("contacts: '" + tree.name() + "': friction must be >= 0, restitution from 0 to 1");
  parts_.push_back({mover, &tree, surface, part_of_.size()});
  part_of_.insert(part_of_.end(), tree.solids().size(), static_cast<std::uint32_t>(parts_.size() - 1));
  return static_cast<std::uint32_t>(parts_.size() - 1);
}

void NarrowphaseContacts::exempt(const Mover& a, const Mover& b) { exempt_.emplace_back(a, b); }

void NarrowphaseContacts::exempt_parts(std::uint32_t a, std::uint32_t b) {
  exempt_parts_.emplace_back(std::min(a, b), std::max(a, b));
}

bool NarrowphaseContacts::is_exempt(std::uint32_t part_a, std::uint32_t part_b) const {
  const Mover &a = parts_[part_a].mover, &b = parts_[part_b].mover;
  if (a == b) return true;
  const std::pair parts(std::min(part_a, part_b), std::max(part_a, part_b));
  if (std::binary_search(exempt_parts_.begin(), exempt_parts_.end(), parts)) return true;
  return std::any_of(exempt_.begin(), exempt_.end(), [&](const auto& pair) {
    return (pair.first == a && pair.second == b) || (pair.first == b && pair.second == a);
  });
}

void NarrowphaseContacts::build() {
  if (parts_.empty()) throw InputError("contacts: nothing to find any between");
  std::sort(exempt_parts_.begin(), exempt_parts_.end());
  std::vector<const HexahedronTree*> trees;
  std::vector<Hexahedron> solids;
  std::vector<std::uint8_t> is_static;
  all_.clear();
  for (const Part& part : parts_) {
    all_.push_back(static_cast<std::uint32_t>(trees.size()));
    trees.push_back(part.tree);
    is_static.push_back(part.mover.kind == Mover::Kind::ground ? 1 : 0);
    for (const PlacedHexahedron& placed : part.tree->solids()) solids.push_back(placed.solid);
  }
  BroadphaseInput input;
  input.trees = trees;
  input.margin = margin_;
  input.is_static = is_static;
  broadphase_->build(input);
  narrowphase_->build(solids);
  workspace_ = narrowphase_->make_workspace();
  poses_.resize(solids.size());
  block_.resize(kBlock);
  status_.resize(kBlock);
  geometry_.resize(kBlock);
  points_.resize(kBlock * kMaxManifoldPoints);
}

/// Whether the face of a solid that a contact's normal leaves by lies against another solid of its object, as
/// at a seam: nothing touches it there. Looked at a millionth of the way from the point to the middle of the
/// face, a billionth of the solid's size outside.
bool NarrowphaseContacts::is_covered(SolidIndex solid, const Vector3& p_W, const Vector3& n_W) const {
  const Part& part = parts_[part_of_[solid]];
  const std::span<const PlacedHexahedron> solids = part.tree->solids();
  if (solids.size() < 2) return false;
  const Hexahedron& own = solids[solid - part.first_solid].solid;
  const Pose& X_WS = poses_[solid];
  int face = 0;
  double most = -2.0;
  for (int f = 0; f < 6; ++f) {
    const double along = dot(rotate(X_WS.R, own.face_plane(f).normal), n_W);
    if (along > most) most = along, face = f;
  }
  Vector3 middle = Vector3::Zero();
  for (const std::uint8_t corner : Hexahedron::kFaceVertices[static_cast<std::size_t>(face)])
    middle += 0.25 * own.vertices()[corner];
  const Vector3 q_W =
      (p_W + 0x1p-20 * (touchstone::transform(X_WS, middle) - p_W)) + (0x1p-30 * own.size()) * n_W;
  for (std::size_t i = 0; i < solids.size(); ++i) {
    if (part.first_solid + i == solid) continue;
    const Hexahedron& other = solids[i].solid;
    const Vector3 q = touchstone::transform(inverse(poses_[part.first_solid + i]), q_W);
    bool is_inside = true;
    for (int f = 0; f < 6 && is_inside; ++f) is_inside = other.face_plane(f).signed_distance(q) < 0.0;
    if (is_inside) return true;
  }
  return false;
}

std::span<const Contact> NarrowphaseContacts::find(const DynamicsWorld& world) {
  contacts_.clear();
  origins_.clear();
  undecided_ = failed_ = 0;
  for (const Part& part : parts_)
    find_global_positions(*part.tree, pose_of(part.mover, world),
                          std::span(poses_).subspan(part.first_solid, part.tree->solids().size()));
  broadphase_->update(poses_, all_);
  const Query query{QueryKind::manifold, margin_, kMaxManifoldPoints};
  for (PairCursor cursor; !cursor.done;) {
    const std::size_t found = broadphase_->find_pairs(cursor, block_);
    const auto end =
        std::remove_if(block_.begin(), block_.begin() + static_cast<std::ptrdiff_t>(found),
                       [&](const SolidPair& pair) { return is_exempt(part_of_[pair.a], part_of_[pair.b]); });
    const auto count = static_cast<std::size_t>(end - block_.begin());
    narrowphase_->evaluate({std::span(block_).first(count), poses_, query, {}},
                           {std::span(status_).first(count), std::span(geometry_).first(count), points_},
                           *workspace_);
    for (std::size_t i = 0; i < count; ++i)
      take(block_[i], status_[i], geometry_[i],
           std::span(points_).subspan(i * kMaxManifoldPoints, kMaxManifoldPoints));
  }
  return contacts_;
}

void NarrowphaseContacts::take(const SolidPair& pair, PairStatus status, const PairGeometry& geometry,
                               std::span<const ContactPoint> points) {
  if (status == PairStatus::failed || status == PairStatus::unsupported) {
    ++failed_;
    return;
  }
  undecided_ += status == PairStatus::undecided ? 1 : 0;
  if (!(geometry.separation <= margin_)) return;
  const Part &a = parts_[part_of_[pair.a]], &b = parts_[part_of_[pair.b]];
  const double friction = std::sqrt(a.surface.friction * b.surface.friction);
  const double restitution = std::max(a.surface.restitution, b.surface.restitution);
  for (std::size_t i = 0; i < static_cast<std::size_t>(geometry.point_count); ++i) {
    const ContactPoint& point = points[i];
    const Vector3& n = geometry.n_AB_W;
    if (is_covered(pair.a, point.p_A_W, n) || is_covered(pair.b, point.p_B_W, -n)) continue;
    contacts_.push_back({a.mover, b.mover, geometry.n_AB_W, point.p_A_W, point.p_B_W, friction, restitution,
                         key_of(pair, point.feature_id, i)});
    origins_.push_back({pair, status, point.separation});
  }
}

}  // namespace touchstone::physics
