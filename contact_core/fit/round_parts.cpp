#include "touchstone/contact_core/fit/round_parts.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "touchstone/contact_core/geometry/disjoint_sets.hpp"

namespace touchstone {
namespace {

constexpr double kSmooth = 0.8191520442889918;     // cosine of 35 degrees
constexpr double kRound = 1e-3;                    // share of the radius; sine of what a facet leans
constexpr double kWidestGap = 0.7071067811865476;  // cosine of 45 degrees, between corners next to each other
constexpr std::size_t kFewestFacets = 8;

// Triangles that meet in edges without a sharp turn, patch by patch.
std::vector<std::vector<std::uint32_t>> smooth_patches(const TriangleMesh& mesh) {
  DisjointSets joined(mesh.triangles.size());
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> sides;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vector3 n = area_vector(mesh, t);
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t a = mesh.triangles[t][i], b = mesh.triangles[t][(i + 1) % 3];
      const auto [known, is_new] = sides.try_emplace(std::minmax(a, b), t);
      if (is_new) continue;
      const Vector3 other = area_vector(mesh, known->second);
      if (dot(n, other) < kSmooth * norm(n) * norm(other)) continue;
      joined.join(t, known->second);
    }
  }
  std::map<std::uint32_t, std::vector<std::uint32_t>> patches;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) patches[joined.least_of(t)].push_back(t);
  std::vector<std::vector<std::uint32_t>> result;
  for (auto& [root, patch] : patches)
    if (patch.size() >= kFewestFacets) result.push_back(std::move(patch));
  return result;
}

// Across all facets' normals, where there is such a direction.
std::optional<Vector3> axis_of(const TriangleMesh& mesh, const std::vector<std::uint32_t>& patch) {
  const Vector3 first = area_vector(mesh, patch.front());
  Vector3 axis = Vector3::Zero();
  for (const std::uint32_t t : patch) {
    const Vector3 n = area_vector(mesh, t);
    if (norm(n) == 0.0) return std::nullopt;
    const Vector3 across = cross(first, n) / norm(n);
    if (norm(across) > norm(axis)) axis = across;
  }
  if (norm(axis) < 0.1 * norm(first)) return std::nullopt;
  axis /= norm(axis);
  Eigen::Index main = 0;
  axis.cwiseAbs().maxCoeff(&main);
  if (axis(main) < 0.0) axis = -axis;
  for (const std::uint32_t t : patch) {
    const Vector3 n = area_vector(mesh, t);
    if (std::abs(dot(n, axis)) > kRound * norm(n)) return std::nullopt;
  }
  return axis;
}

// The centre of the circle through three points, and whether all are on it.
std::optional<Vector3> circle_centre(const std::vector<Vector3>& flat, const Vector3& axis) {
  const auto farthest_from = [&](const auto& key) {
    return *std::max_element(flat.begin(), flat.end(),
                             [&](const Vector3& p, const Vector3& q) { return key(p) < key(q); });
  };
  const Vector3 a = flat.front();
  const Vector3 b = farthest_from([&](const Vector3& p) { return norm(p - a); });
  const Vector3 c = farthest_from([&](const Vector3& p) { return norm(cross(p - a, b - a)); });
  const Vector3 u = b - a, v = c - a, n = cross(u, v);
  const double twice = 2.0 * dot(n, n);
  if (twice == 0.0 || std::abs(dot(n, axis)) < 0.9 * norm(n)) return std::nullopt;
  const Vector3 centre = a + (dot(u, u) * cross(v, n) + dot(v, v) * cross(n, u)) / twice;
  const double radius = norm(a - centre);
  for (const Vector3& p : flat)
    if (std::abs(norm(p - centre) - radius) > kRound * radius) return std::nullopt;
  return centre;
}

constexpr double kWholeTurn = 2.0 * std::numbers::pi;

// The turns from each direction that a corner has from the centre to the next one, counter-clockwise.
std::vector<double> turns_around(const std::vector<Vector3>& flat, const Vector3& centre,
                                 const Vector3& axis) {
  const Vector3 x = (flat.front() - centre) / norm(flat.front() - centre), y = cross(axis, x);
  std::vector<double> angles;
  for (const Vector3& p : flat) angles.push_back(std::atan2(dot(p - centre, y), dot(p - centre, x)));
  std::sort(angles.begin(), angles.end());
  std::vector<double> turns = {kWholeTurn - (angles.back() - angles.front())};
  for (std::size_t i = 1; i < angles.size(); ++i) turns.push_back(angles[i] - angles[i - 1]);
  return turns;
}

// As many facets as go around, where all are equally wide: corners above each other have no turn between.
int count_equal(const std::vector<double>& turns) {
  const double widest = *std::max_element(turns.begin(), turns.end());
  const auto count = std::count_if(turns.begin(), turns.end(),
                                   [&](double turn) { return std::abs(turn - widest) <= kRound * widest; });
  const bool are_all = std::all_of(turns.begin(), turns.end(), [&](double turn) {
    return std::abs(turn - widest) <= kRound * widest || turn <= kRound * widest;
  });
  return are_all && std::abs(static_cast<double>(count) * widest - kWholeTurn) <= kRound * kWholeTurn
             ? static_cast<int>(count)
             : 0;
}

std::optional<RoundPart> round_part(const MeshDistance& distance, const std::vector<std::uint32_t>& patch) {
  const TriangleMesh& mesh = distance.mesh();
  const std::optional<Vector3> axis = axis_of(mesh, patch);
  if (!axis) return std::nullopt;
  // The vertices are projected along the axis.
  std::vector<Vector3> flat;
  double low = 1e300, high = -1e300;
  for (const std::uint32_t t : patch) {
    for (const std::uint32_t corner : mesh.triangles[t]) {
      const Vector3& p = mesh.vertices[corner];
      const double along = dot(p, *axis);
      low = std::min(low, along);
      high = std::max(high, along);
      flat.push_back(p - along * *axis);
    }
  }
  // They have to lie on a circle and to go all around it.
  const std::optional<Vector3> centre = circle_centre(flat, *axis);
  if (!centre) return std::nullopt;
  const std::vector<double> turns = turns_around(flat, *centre, *axis);
  if (std::cos(std::min(*std::max_element(turns.begin(), turns.end()), std::numbers::pi)) < kWidestGap)
    return std::nullopt;
  const double radius = norm(flat.front() - *centre);
  const Vector3 foot = *centre + (low - dot(*centre, *axis)) * *axis;
  // A point a hair inwards from a facet's middle says which side is solid.
  const auto& facet = mesh.triangles[patch.front()];
  const Vector3 middle = (mesh.vertices[facet[0]] + mesh.vertices[facet[1]] + mesh.vertices[facet[2]]) / 3.0;
  const Vector3 off = middle - foot, out = off - dot(off, *axis) * *axis;
  const bool is_bore = !distance.is_inside(middle - kRound * out);
  return RoundPart{
      foot, *axis, (flat.front() - *centre) / radius, high - low, radius, is_bore, count_equal(turns)};
}

}  // namespace

Bounds RoundPart::bounds() const {
  Bounds box;
  for (const Vector3& end : {foot, Vector3(foot + length * axis)}) {
    Vector3 across;
    for (int i = 0; i < 3; ++i) across(i) = radius * std::sqrt(std::max(0.0, 1.0 - axis(i) * axis(i)));
    box.add(end - across);
    box.add(end + across);
  }
  return box;
}

std::vector<RoundPart> find_round_parts(const MeshDistance& mesh) {
  std::vector<RoundPart> parts;
  for (const std::vector<std::uint32_t>& patch : smooth_patches(mesh.mesh()))
    if (const std::optional<RoundPart> part = round_part(mesh, patch)) parts.push_back(*part);
  return parts;
}

}  // namespace touchstone
