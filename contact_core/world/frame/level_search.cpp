#include "touchstone/contact_core/world/frame/level_search.hpp"

#include <algorithm>
#include <array>

#include "touchstone/contact_core/geometry/norms.hpp"

namespace touchstone {
namespace {

/// Of the coordinates that make up a point in the world: more than all that follows rounds.
constexpr double kRounding = 0x1p-44;
/// Matrices may be rotations to a millionth only: by so much they make anything longer at most.
constexpr double kLonger = 1.0 + 1e-5;

/// A bound in the world; vertices and normals once they are asked for.
class Bound {
 public:
  Bound(const SearchedBody& body, std::int32_t node) : body_(body), node_(node) {
    const Sphere& sphere = node < 0 ? body.solids->bounding_sphere() : here().sphere_O;
    centre_ = transform(body.X_W, sphere.centre), radius_ = sphere.radius * kLonger;
    coordinates_ = norm_1(body.X_W.p);
    if (body.levels != nullptr) coordinates_ += body.levels->extent();
  }

  bool is_leaf() const { return node_ < 0 || here().solid >= 0; }
  SolidIndex solid() const {
    return node_ < 0 ? body_.first : body_.first + static_cast<SolidIndex>(here().solid);
  }
  Bound left() const { return {body_, here().left}; }
  Bound right() const { return {body_, here().right}; }
  const Vector3& centre() const { return centre_; }
  double radius() const { return radius_; }
  /// At least any coordinate that the bound is placed by: these may cancel out in its centre [m].
  double coordinates() const { return norm_1(centre_) + coordinates_; }

  /// Unit normals of faces, to kLonger; none of what is known as a sphere only.
  std::span<const Vector3> normals() {
    place();
    return std::span(normals_).first(normal_count_);
  }
  /// How far it reaches along a unit vector, and against it [m].
  std::pair<double, double> along(const Vector3& n) {
    place();
    const double at = dot(n, centre_);
    const double around = radius_ * kLonger, rounded_by = rounded_by_ * kLonger;
    if (normal_count_ == 0) return {at - around, at + around};
    double low = dot(n, vertices_.vertex(0)), high = low;
    for (int i = 1; i < Hexahedron::kVertices; ++i) {
      const double x = dot(n, vertices_.vertex(i));
      low = std::min(low, x), high = std::max(high, x);
    }
    return {std::max(low - rounded_by, at - around), std::min(high + rounded_by, at + around)};
  }

 private:
  const ObjectLevels::Node& here() const { return body_.levels->nodes()[static_cast<std::size_t>(node_)]; }

  void place() {
    if (is_placed_) return;
    is_placed_ = true;
    if (is_leaf())
      place_solid();
    else if (here().shape >= 0)
      place_shape(body_.levels->shapes()[static_cast<std::size_t>(here().shape)]);
  }

  void place_solid() {
    const std::size_t i = node_ < 0 ? 0 : static_cast<std::size_t>(here().solid);
    const Hexahedron& solid = body_.solids[i];
    const Pose X_WS = body_.X_OS == nullptr ? body_.X_W : compose(body_.X_W, body_.X_OS[i]);
    world_vertices(solid, X_WS, vertices_);
    for (int face = 0; face < 6; ++face) add_normal(rotate(X_WS.R, solid.face_plane(face).normal));
    rounded_by_ = solid.radius();
  }

  void place_shape(const ObjectLevels::Shape& shape) {
    for (int i = 0; i < Hexahedron::kVertices; ++i) {
      const Vector3 p = transform(body_.X_W, shape.vertices_O.vertex(i));
      const auto k = static_cast<std::size_t>(i);
      vertices_.x[k] = p.x(), vertices_.y[k] = p.y(), vertices_.z[k] = p.z();
    }
    for (const Vector3& normal_O : shape.normals_O) add_normal(rotate(body_.X_W.R, normal_O));
    rounded_by_ = shape.radius;
  }

  void add_normal(const Vector3& n) {
    if (n != Vector3::Zero()) normals_[normal_count_++] = n;
  }

  const SearchedBody& body_;
  std::int32_t node_;  // -1: the body is one hexahedron
  Vector3 centre_;
  double radius_;
  double coordinates_;
  bool is_placed_ = false;
  WorldVertices vertices_;
  std::array<Vector3, 6> normals_;
  std::size_t normal_count_ = 0;
  double rounded_by_ = 0.0;
};

bool are_apart_along(const Vector3& n, Bound& a, Bound& b, double reach) {
  const auto [low_a, high_a] = a.along(n);
  const auto [low_b, high_b] = b.along(n);
  return std::max(low_b - high_a, low_a - high_b) > reach;
}

bool are_apart(Bound& a, Bound& b, double reach) {
  // Their spheres take out most.
  const Vector3 offset = b.centre() - a.centre();
  const double distance = norm(offset);
  const double rounding = kRounding * (a.coordinates() + b.coordinates() + a.radius() + b.radius());
  const double within = (reach + rounding) * (1.0 + kRounding);
  if (distance > a.radius() + b.radius() + within) return true;
  // Then axes do.
  const double along_axis = within * kLonger;
  if (distance > 0.0 && are_apart_along(offset / distance, a, b, along_axis)) return true;
  for (const Vector3& n : a.normals())
    if (are_apart_along(n, a, b, along_axis)) return true;
  for (const Vector3& n : b.normals())
    if (are_apart_along(n, a, b, along_axis)) return true;
  return false;
}

void descend(double reach, Bound& a, Bound& b, std::vector<SolidPair>& out) {
  if (are_apart(a, b, reach)) return;
  if (a.is_leaf() && b.is_leaf()) {
    out.push_back({std::min(a.solid(), b.solid()), std::max(a.solid(), b.solid())});
    return;
  }
  // The larger of the two is opened.
  const bool opens_a = b.is_leaf() || (!a.is_leaf() && a.radius() >= b.radius());
  Bound left = opens_a ? a.left() : b.left(), right = opens_a ? a.right() : b.right();
  for (Bound* child : {&left, &right})
    opens_a ? descend(reach, *child, b, out) : descend(reach, a, *child, out);
}

}  // namespace

void find_pairs_within(double reach, const SearchedBody& a, const SearchedBody& b,
                       std::vector<SolidPair>& out) {
  Bound root_a(a, a.levels == nullptr ? -1 : 0), root_b(b, b.levels == nullptr ? -1 : 0);
  descend(reach, root_a, root_b, out);
}

}  // namespace touchstone
