#include "touchstone/contact_core/broadphase/world_spheres.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/norms.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/memory/reserve_more.hpp"

namespace touchstone {
namespace {

constexpr double kEps = 2.0 * kUnitRoundoff;

/// And for more, which come later.
void reserve(SolidTable& table, std::size_t objects, std::size_t solids) {
  reserve_more(table.first_solid, objects + 1);
  reserve_more(table.is_static, objects), reserve_more(table.is_gone, objects);
  reserve_more(table.sphere_S, solids), reserve_more(table.object_of, solids);
}

}  // namespace

SolidTable make_solid_table(const BroadphaseInput& input) {
  if (!(input.margin >= 0.0) || !std::isfinite(input.margin))
    throw InputError("broadphase: margin is " + std::to_string(input.margin) + ", must be finite and >= 0");
  if (!input.is_static.empty() && input.is_static.size() != input.trees.size())
    throw InputError("broadphase: " + std::to_string(input.is_static.size()) + " static flags for " +
                     std::to_string(input.trees.size()) + " objects");
  SolidTable table;
  std::size_t solids = 0;
  for (const HexahedronTree* tree : input.trees) solids += tree == nullptr ? 0 : tree->solids().size();
  reserve(table, input.trees.size(), solids);
  for (std::size_t object = 0; object < input.trees.size(); ++object) {
    if (input.trees[object] == nullptr)
      throw InputError("broadphase: tree " + std::to_string(object) + " is null");
    table.first_solid.push_back(static_cast<std::uint32_t>(table.sphere_S.size()));
    for (const PlacedHexahedron& placed : input.trees[object]->solids()) {
      table.sphere_S.push_back(placed.solid.bounding_sphere());
      table.object_of.push_back(static_cast<std::uint32_t>(object));
    }
  }
  table.first_solid.push_back(static_cast<std::uint32_t>(table.sphere_S.size()));
  table.is_static.assign(input.is_static.begin(), input.is_static.end());
  table.is_static.resize(input.trees.size());
  table.is_gone.resize(input.trees.size());
  return table;
}

void set_object(SolidTable& table, std::uint32_t object, const HexahedronTree* tree, bool is_static) {
  const bool is_new = object == table.objects();
  if (tree == nullptr && is_new) throw InputError("broadphase: no tree for another object");
  if (tree == nullptr) {
    table.is_gone[object] = 1;
    return;
  }
  const auto count = static_cast<std::uint32_t>(tree->solids().size());
  if (!is_new && count != table.first_solid[object + 1] - table.first_solid[object])
    throw InputError("broadphase: a tree of " + std::to_string(count) + " solids in the place of one of " +
                     std::to_string(table.first_solid[object + 1] - table.first_solid[object]));
  if (is_new) {
    reserve(table, table.objects() + 1, table.solids() + count);
    table.first_solid.push_back(table.solids() + count);
    table.sphere_S.resize(table.solids());
    table.object_of.resize(table.solids(), object);
    table.is_static.push_back(0), table.is_gone.push_back(0);
  }
  table.is_static[object] = is_static ? 1 : 0, table.is_gone[object] = 0;
  for (std::uint32_t i = 0; i < count; ++i)
    table.sphere_S[table.first_solid[object] + i] = tree->solids()[i].solid.bounding_sphere();
}

// Stretch: a valid pose has |R^T R - I|_ij <= t, so by Gershgorin |R v|^2 <= (1 + 3t) |v|^2, and sqrt(1 + 3t)
// < 1 + 1.5t. Rounding: a transformed coordinate takes at most 4 roundings, so it is off by less than 2 eps
// (|R_i| |v| + |p_i|). That happens to the centre and to a vertex, in three coordinates: less than 2 sqrt(3)
// 2 eps (|v| + |p|) < 8 eps (...), where |v| <= sqrt(3) |c| + r in largest magnitudes. DBL_MIN covers what
// underflows.
Sphere world_sphere(const Sphere& sphere_S, const Pose& X_WS) {
  const double reach = 2.0 * norm_inf(sphere_S.centre) + sphere_S.radius;
  const double slack = 8 * kEps * (reach + norm_inf(X_WS.p)) + std::numeric_limits<double>::min();
  return {transform(X_WS, sphere_S.centre), sphere_S.radius * (1.0 + 2.0 * kRotationTolerance) + slack};
}

// 8 eps of slack against 4 roundings: the sphere test alone decides.
Box bounding_box(const Sphere& sphere, double margin) {
  Box box;
  for (int i = 0; i < 3; ++i) {
    const double reach = sphere.radius + margin;
    const double slack = 16 * kEps * (reach + std::abs(sphere.centre(i)));
    // may_touch() lets distances up to sqrt(DBL_MIN) pass where squares underflow.
    const double half = reach + slack + 0x1p-510;
    const bool finite = std::isfinite(sphere.centre(i)) && std::isfinite(half);
    box.low[i] = finite ? sphere.centre(i) - half : -kInfinity;
    box.high[i] = finite ? sphere.centre(i) + half : kInfinity;
  }
  return box;
}

// Centre on the line between the centres; the radius is then measured, so the centre's rounding does not
// matter. A measured distance is off by less than 4 eps of itself.
Sphere enclosing_sphere(const Sphere& a, const Sphere& b) {
  const Vector3 between = b.centre - a.centre;
  const double distance = norm(between);
  double weight = distance > 0.0 ? 0.5 + 0.5 * ((b.radius - a.radius) / distance) : 0.5;
  weight = std::clamp(weight, 0.0, 1.0);
  const Vector3 centre = a.centre + weight * between;
  const double to_a = norm(centre - a.centre) * (1.0 + 4 * kEps) + a.radius;
  const double to_b = norm(centre - b.centre) * (1.0 + 4 * kEps) + b.radius;
  // Squares of distances below 1e-154 underflow in norm(): 1e-150 is more than such a distance.
  const double radius = std::max(to_a, to_b) * (1.0 + 2 * kEps) + 1e-150;
  return {centre, std::isfinite(distance) ? radius : kInfinity};
}

}  // namespace touchstone
