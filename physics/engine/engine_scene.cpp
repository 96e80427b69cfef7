#include "touchstone/physics/engine/engine_scene.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "touchstone/contact_core/scene/scene_instance.hpp"

namespace touchstone::physics {
namespace {

bool is_diagonal(const Matrix3& I) {
  return I(0, 1) == 0.0 && I(0, 2) == 0.0 && I(1, 2) == 0.0 && I(1, 0) == 0.0 && I(2, 0) == 0.0 &&
         I(2, 1) == 0.0;
}

/// Columns: the principal axes, right-handed. The axes as they are where they do.
Matrix3 principal_axes(const Matrix3& I, Vector3& moments) {
  if (is_diagonal(I)) {
    moments = I.diagonal();
    return Matrix3::Identity();
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(0.5 * (I + I.transpose()));
  moments = solver.eigenvalues().cwiseMax(0.0);
  Matrix3 R = solver.eigenvectors();
  if (R.determinant() < 0.0) R.col(2) = -R.col(2);
  return R;
}

ContactSide side_of(BodyKind kind) {
  if (kind == BodyKind::kinematic) return ContactSide::kinematic;
  if (kind == BodyKind::dynamic) return ContactSide::body;
  return kind == BodyKind::link ? ContactSide::link : ContactSide::ground;
}

template <class Pair>
void sort_unique(std::vector<Pair>& pairs) {
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
}

std::pair<std::size_t, std::size_t> ordered(std::size_t a, std::size_t b) { return std::minmax(a, b); }

}  // namespace

EngineScene::EngineScene(const DynamicScene& scene)
    : scene_(&scene),
      surfaces_(surface_pairs(scene)),
      body_of_(scene.bodies.size(), kNone),
      X_BO_(scene.bodies.size()) {
  // Links that fixed joints make one share a body; every other object has its own.
  cluster_links();
  for (std::size_t i = 0; i < body_of_.size(); ++i) {
    if (body_of_[i] == kNone) {
      body_of_[i] = bodies_.size();
      bodies_.push_back({});
      bodies_.back().kind = side_of(scene.bodies[i].kind);
    }
    bodies_[body_of_[i]].objects.push_back(i);
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) place(b);
  // A solid at its object's origin keeps the object's pose to the bit.
  for (std::size_t i = 0; i < body_of_.size(); ++i)
    for (const PlacedHexahedron& placed : scene.scene.objects[i].tree.solids()) {
      bodies_[body_of_[i]].solids.push_back(static_cast<SolidIndex>(solids_.size()));
      const bool is_at = placed.X_OS.R == Matrix3::Identity() && placed.X_OS.p == Vector3::Zero();
      solids_.push_back({&placed.solid, i, body_of_[i], is_at ? X_BO_[i] : compose(X_BO_[i], placed.X_OS)});
    }
  // Joints and exemptions name bodies, so these come first.
  add_joints();
  add_body_joints();
  start_links();
  list_exempt();
  compare_exempt();
}

/// One body for links that fixed joints join; a link fixed to the ground is ground.
void EngineScene::cluster_links() {
  // Links that fixed joints connect get one cluster number.
  std::vector<std::size_t> cluster(body_of_.size());
  for (std::size_t i = 0; i < cluster.size(); ++i) cluster[i] = i;
  for (const SceneMechanism& mechanism : scene_->mechanisms)
    for (const SceneJoint& joint : mechanism.joints) {
      if (joint.kind != JointKind::fixed || joint.parent == kNoObject) continue;
      if (scene_->bodies[joint.parent].kind == BodyKind::fixed) continue;
      const std::size_t from = cluster[joint.child], to = cluster[joint.parent];
      std::replace(cluster.begin(), cluster.end(), from, to);
    }
  // Each cluster becomes one body.
  std::map<std::size_t, std::size_t> body_of_cluster;
  for (std::size_t i = 0; i < cluster.size(); ++i) {
    if (scene_->bodies[i].kind != BodyKind::link) continue;
    const auto [at, is_new] = body_of_cluster.try_emplace(cluster[i], bodies_.size());
    if (is_new) {
      bodies_.push_back({});
      bodies_.back().kind = ContactSide::link;
    }
    body_of_[i] = at->second;
  }
  // A cluster that is fixed to the ground becomes ground.
  for (const SceneMechanism& mechanism : scene_->mechanisms)
    for (const SceneJoint& joint : mechanism.joints) {
      const bool is_ground =
          joint.parent == kNoObject || scene_->bodies[joint.parent].kind == BodyKind::fixed;
      if (joint.kind == JointKind::fixed && is_ground)
        bodies_[body_of_[joint.child]].kind = ContactSide::ground;
    }
}

/// The body's frame, and its objects in it.
void EngineScene::place(std::size_t index) {
  // The body's frame starts as that of its first object.
  Body& body = bodies_[index];
  const std::size_t first = body.objects[0];
  const Pose& X_WF = scene_->scene.objects[first].X_WO;
  body.name = object_name(*scene_, first);
  body.X_WB = X_WF;
  const Pose X_FW = inverse(X_WF);
  // A dynamic body's frame moves to its centre of mass, along the principal axes.
  Pose X_FB;
  if (body.kind == ContactSide::body || body.kind == ContactSide::link) {
    BodyInertia sum;
    for (const std::size_t i : body.objects)
      add_inertia(sum, i == first ? scene_->bodies[i].inertia
                                  : physics::transform(compose(X_FW, scene_->scene.objects[i].X_WO),
                                                       scene_->bodies[i].inertia));
    body.mass = sum.mass;
    X_FB.R = principal_axes(sum.inertia_B, body.moments);
    X_FB.p = sum.centre_B;
    const bool is_at = X_FB.R == Matrix3::Identity() && X_FB.p == Vector3::Zero();
    if (!is_at) body.X_WB = compose(X_WF, X_FB);
  }
  // The objects' poses are expressed in that frame.
  const bool is_at = X_FB.R == Matrix3::Identity() && X_FB.p == Vector3::Zero();
  for (const std::size_t i : body.objects) {
    if (i == first)
      X_BO_[i] = is_at ? Pose{} : inverse(X_FB);
    else
      X_BO_[i] = compose(inverse(body.X_WB), scene_->scene.objects[i].X_WO);
  }
  // Free bodies have initial velocities.
  if (body.kind == ContactSide::body) {
    body.v_W = scene_->bodies[first].v_W;
    body.w_W = scene_->bodies[first].w_W;
  }
}

void EngineScene::add_joints() {
  // Each joint that moves is listed with its parent and child bodies.
  for (std::size_t m = 0; m < scene_->mechanisms.size(); ++m) {
    const SceneMechanism& mechanism = scene_->mechanisms[m];
    for (std::size_t j = 0; j < mechanism.joints.size(); ++j) {
      const SceneJoint& joint = mechanism.joints[j];
      if (joint.kind == JointKind::fixed) continue;
      std::size_t parent = joint.parent == kNoObject ? kNone : body_of_[joint.parent];
      if (parent != kNone && bodies_[parent].kind == ContactSide::ground) parent = kNone;
      joints_.push_back({{m, j},
                         "joint '" + mechanism.name + "." + joint.name + "'",
                         &joint,
                         parent,
                         body_of_[joint.child]});
    }
  }
  // Parents first: as many passes as the chain is long do.
  std::vector<Joint> sorted;
  std::vector<std::uint8_t> is_placed(bodies_.size(), 0);
  while (sorted.size() < joints_.size()) {
    const std::size_t before = sorted.size();
    for (const Joint& joint : joints_) {
      if (is_placed[joint.child] != 0 || (joint.parent != kNone && is_placed[joint.parent] == 0)) continue;
      is_placed[joint.child] = 1;
      sorted.push_back(joint);
    }
    if (sorted.size() == before) break;  // no tree: validate() has refused it
  }
  joints_ = std::move(sorted);
}

void EngineScene::add_body_joints() {
  const auto body = [&](std::size_t object) {
    const bool is_ground = object == kNoObject || bodies_[body_of_[object]].kind == ContactSide::ground;
    return is_ground ? kNone : body_of_[object];
  };
  for (const SceneBodyJoint& joint : scene_->joints)
    body_joints_.push_back({&joint, body(joint.parent), body(joint.child)});
}

/// Velocities of links, from the rates of the joints that carry them.
void EngineScene::start_links() {
  for (const Joint& joint : joints_) {
    Body& child = bodies_[joint.child];
    Vector3 v = Vector3::Zero(), w = Vector3::Zero();
    if (joint.parent != kNone) {
      const Body& parent = bodies_[joint.parent];
      w = parent.w_W;
      v = parent.v_W + cross(w, child.X_WB.p - parent.X_WB.p);
    }
    const Vector3 along = joint.source->rate * joint.source->axis_W;
    if (joint.source->kind == JointKind::revolute) {
      w += along;
      v += cross(along, child.X_WB.p - joint.source->p_W);
    } else {
      v += along;
    }
    child.v_W = v, child.w_W = w;
  }
}

Surface EngineScene::pair_surface(SolidIndex a, SolidIndex b) const {
  return surfaces_.between(static_cast<std::uint32_t>(solids_[a].object), surface(a),
                           static_cast<std::uint32_t>(solids_[b].object), surface(b));
}

void EngineScene::list_exempt() {
  for (const ExemptPair& pair : scene_->scene.exempt_pairs)
    for (const SolidIndex a : find_solids(scene_->scene, pair.first))
      for (const SolidIndex b : find_solids(scene_->scene, pair.second))
        if (solids_[a].body != solids_[b].body) exempt_solids_.push_back({std::min(a, b), std::max(a, b)});
  for (const SceneMechanism& mechanism : scene_->mechanisms)
    for (const SceneJoint& joint : mechanism.joints)
      if (joint.parent != kNoObject) exempt_objects_.push_back(ordered(joint.parent, joint.child));
  for (const SceneBodyJoint& joint : scene_->joints)
    if (joint.parent != kNoObject) exempt_objects_.push_back(ordered(joint.parent, joint.child));
  sort_unique(exempt_solids_);
  sort_unique(exempt_objects_);
}

bool EngineScene::is_checked(SolidIndex a, SolidIndex b) const {
  const Solid &solid_a = solids_[a], &solid_b = solids_[b];
  if (solid_a.body == solid_b.body) return false;
  const auto is_commanded = [](ContactSide kind) {
    return kind == ContactSide::ground || kind == ContactSide::kinematic;
  };
  if (is_commanded(bodies_[solid_a.body].kind) && is_commanded(bodies_[solid_b.body].kind)) return false;
  if (!has_exemptions()) return true;
  if (std::binary_search(exempt_solids_.begin(), exempt_solids_.end(),
                         SolidPair{std::min(a, b), std::max(a, b)}))
    return false;
  return !std::binary_search(exempt_objects_.begin(), exempt_objects_.end(),
                             ordered(solid_a.object, solid_b.object));
}

/// Checks the rest of the bodies that the lists name.
void EngineScene::compare_exempt() {
  std::vector<std::pair<std::size_t, std::size_t>> named;
  for (const SolidPair& pair : exempt_solids_)
    named.push_back(ordered(solids_[pair.a].body, solids_[pair.b].body));
  for (const auto& [a, b] : exempt_objects_)
    if (body_of_[a] != body_of_[b]) named.push_back(ordered(body_of_[a], body_of_[b]));
  sort_unique(named);
  for (const auto& [a, b] : named) {
    bool any_checked = false, any_exempt = false;
    for (const SolidIndex i : bodies_[a].solids)
      for (const SolidIndex k : bodies_[b].solids) (is_checked(i, k) ? any_checked : any_exempt) = true;
    if (!any_checked) exempt_bodies_.emplace_back(a, b);
    if (any_checked && any_exempt && partly_exempt_.empty())
      partly_exempt_ = bodies_[a].name + " and " + bodies_[b].name;
  }
}

}  // namespace touchstone::physics
