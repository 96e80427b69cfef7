#include "touchstone/adapters/mesh_files/weld.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "touchstone/contact_core/fit/mesh_distance.hpp"
#include "touchstone/contact_core/fit/meshes/places.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/disjoint_sets.hpp"
#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/geometry/orientation.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::mesh_files {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

/// Decided exactly. A triangle with an area has a plane, and no plane holds all four of the points below.
bool has_area(const Vector3& a, const Vector3& b, const Vector3& c) {
  const Vector3 u = b - a, v = c - a;
  constexpr double kSurely = 1e-12;  // far above the product's rounding, 2^-51 of the lengths
  if (norm(cross(u, v)) > kSurely * norm(u) * norm(v)) return true;
  if (a == b || b == c || c == a) return false;
  const std::array<Vector3, 4> points = {Vector3::Zero(), Vector3::UnitX(), Vector3::UnitY(),
                                         Vector3::UnitZ()};
  return std::any_of(points.begin(), points.end(),
                     [&](const Vector3& p) { return numerics::orient3d_sign(a, b, c, p) != 0; });
}

/// @return for each triangle kept, its index in the file.
std::vector<std::uint32_t> take_triangles(const Soup& soup, const ReadTask& task, LoadedMesh& out) {
  std::vector<std::uint32_t> in_file;
  std::vector<std::uint32_t> place_of(soup.vertices.size(), kNoIndex);
  Places places(soup.vertices.size());
  std::vector<Vector3>& kept = out.mesh.vertices;
  MeshReport& report = out.report;
  std::size_t used = 0;
  for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
    // Vertices at one place are welded to one, in the order of their first use.
    Triangle corners{};
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t at = soup.triangles[i][k];
      if (at >= soup.vertices.size())
        task.fail_triangle(i, "vertex " + std::to_string(at) + " of " + std::to_string(soup.vertices.size()));
      if (place_of[at] == kNoIndex) {
        const Vector3 place = soup.vertices[at] + Vector3::Zero();  // -0 becomes 0
        if (!is_finite(place)) task.fail_triangle(i, "a coordinate is not finite");
        place_of[at] = places.index_of(place, kept);
        ++used;
      }
      corners[k] = place_of[at];
    }
    // Triangles without area are left out, and counted for the report.
    if (has_area(kept[corners[0]], kept[corners[1]], kept[corners[2]])) {
      out.mesh.triangles.push_back(corners);
      in_file.push_back(static_cast<std::uint32_t>(i));
    } else if (report.zero_area++ == 0) {
      report.first_zero_area = i;
    }
  }
  // Vertices that no triangle uses do not count as welded.
  report.triangles_read = soup.triangles.size();
  report.vertices_read = soup.vertices.size();
  report.vertices_welded = used - kept.size();
  return in_file;
}

/// An edge of a triangle, so that the same ones stand together once sorted.
struct Side {
  std::uint64_t edge;  // lower vertex << 32 | higher
  std::uint32_t triangle;
  bool is_up;  // runs from the lower to the higher vertex
};

std::vector<Side> sorted_sides(const std::vector<Triangle>& triangles) {
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const std::uint64_t a = triangles[t][k], b = triangles[t][(k + 1) % 3];
      sides.push_back({std::min(a, b) << 32 | std::max(a, b), t, a < b});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& l, const Side& r) {
    return l.edge != r.edge ? l.edge < r.edge : l.triangle < r.triangle;
  });
  return sides;
}

/// The sides of each edge.
template <class Function>
void for_each_edge(const std::vector<Side>& sides, const Function& function) {
  for (std::size_t i = 0, end = 0; i < sides.size(); i = end) {
    for (end = i; end < sides.size() && sides[end].edge == sides[i].edge;) ++end;
    function(std::span(sides).subspan(i, end - i));
  }
}

void count_edges(const std::vector<Triangle>& triangles, const std::vector<std::uint32_t>& in_file,
                 MeshReport& report) {
  const auto count = [&](std::size_t& counter, std::size_t& first, std::uint32_t triangle) {
    if (counter++ == 0 || in_file[triangle] < first) first = in_file[triangle];
  };
  report.turned_edges = report.first_turned = 0;
  report.open_edges = report.crowded_edges = 0;
  for_each_edge(sorted_sides(triangles), [&](std::span<const Side> edge) {
    if (edge.size() == 1) count(report.open_edges, report.first_open, edge[0].triangle);
    if (edge.size() > 2) count(report.crowded_edges, report.first_crowded, edge[0].triangle);
    if (edge.size() == 2 && edge[0].is_up == edge[1].is_up)
      count(report.turned_edges, report.first_turned, edge[0].triangle);
  });
}

/// Triangles beside each other, and whether one of both has to be turned.
struct Neighbours {
  struct Neighbour {
    std::uint32_t triangle;
    bool is_turned;
  };
  std::vector<std::array<Neighbour, 3>> of;
  std::vector<std::uint8_t> count;  ///< of a triangle; 3 where each of its edges is between two
  DisjointSets joined;              ///< triangles, across edges of any number

  explicit Neighbours(const std::vector<Triangle>& triangles)
      : of(triangles.size()), count(triangles.size(), 0), joined(triangles.size()) {
    for_each_edge(sorted_sides(triangles), [&](std::span<const Side> edge) {
      for (const Side& side : edge) joined.join(edge[0].triangle, side.triangle);
      if (edge.size() != 2) return;
      const bool is_turned = edge[0].is_up == edge[1].is_up;
      for (int i = 0; i < 2; ++i)
        of[edge[i].triangle][count[edge[i].triangle]++] = {edge[1 - i].triangle, is_turned};
    });
  }
};

/// A surface from triangle to triangle across edges.
struct Surface {
  std::vector<std::uint32_t> triangles;
  std::size_t facing_other = 0;  ///< than its first triangle
  bool may_be_turned = true;     ///< it has no boundary, and two sides
};

/// @param faces of each triangle, 0: not seen yet, 1: as the surface's first one, 2: the other way
Surface surface_from(std::uint32_t first, const Neighbours& neighbours, std::vector<std::uint8_t>& faces) {
  Surface surface{{first}};
  faces[first] = 1;
  for (std::size_t i = 0; i < surface.triangles.size(); ++i) {
    const std::uint32_t t = surface.triangles[i];
    surface.facing_other += faces[t] == 2 ? 1 : 0;
    surface.may_be_turned = surface.may_be_turned && neighbours.count[t] == 3;
    for (int k = 0; k < neighbours.count[t]; ++k) {
      const auto [other, is_turned] = neighbours.of[t][k];
      const auto facing = static_cast<std::uint8_t>(is_turned ? 3 - faces[t] : faces[t]);
      if (faces[other] == 0) {
        faces[other] = facing;
        surface.triangles.push_back(other);
      } else if (faces[other] != facing) {
        surface.may_be_turned = false;
      }
    }
  }
  return surface;
}

/// Six times the volume that a surface bounds where its triangles face as its first one does.
double six_volumes(const Surface& surface, const std::vector<std::uint8_t>& faces, const TriangleMesh& mesh) {
  const Vector3& about = mesh.vertices[mesh.triangles[surface.triangles[0]][0]];
  double sum = 0.0;
  for (const std::uint32_t t : surface.triangles) {
    const auto& [i, j, k] = mesh.triangles[t];
    const double six =
        dot(mesh.vertices[i] - about, cross(mesh.vertices[j] - about, mesh.vertices[k] - about));
    sum += faces[t] == 1 ? six : -six;
  }
  return sum;
}

/// Boxes of surfaces, joined where they share edges. One that may be turned shares none: it has its own.
class Boxes {
 public:
  Boxes(const TriangleMesh& mesh, Neighbours& neighbours) {
    std::vector<std::uint32_t> place(mesh.triangles.size(), kNoIndex);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const std::uint32_t first = neighbours.joined.least_of(t);
      if (first == t) {
        place[t] = static_cast<std::uint32_t>(boxes_.size());
        boxes_.push_back({{}, t});
      }
      for (const std::uint32_t v : mesh.triangles[t]) boxes_[place[first]].of.add(mesh.vertices[v]);
    }
    // Those that begin first come first, so that most boxes are never asked.
    std::sort(boxes_.begin(), boxes_.end(), [](const Box& l, const Box& r) {
      return l.of.low.x() != r.of.low.x() ? l.of.low.x() < r.of.low.x() : l.first < r.first;
    });
    double farthest = -kInfinity;
    for (const Box& box : boxes_) farthest_.push_back(farthest = std::max(farthest, box.of.high.x()));
  }

  /// @param first the surface's first triangle
  bool may_be_enclosed(std::uint32_t first, const Bounds& box) const {
    const auto end = std::upper_bound(boxes_.begin(), boxes_.end(), box.low.x(),
                                      [](double x, const Box& other) { return x < other.of.low.x(); });
    for (auto i = static_cast<std::size_t>(end - boxes_.begin()); i-- > 0;) {
      if (farthest_[i] < box.high.x()) return false;
      if (boxes_[i].first != first && holds(boxes_[i].of, box)) return true;
    }
    return false;
  }

 private:
  struct Box {
    Bounds of;
    std::uint32_t first;  ///< triangle
  };

  static bool holds(const Bounds& outer, const Bounds& inner) {
    for (int i = 0; i < 3; ++i)
      if (inner.low[i] < outer.low[i] || inner.high[i] > outer.high[i]) return false;
    return true;
  }

  std::vector<Box> boxes_;
  std::vector<double> farthest_;  ///< along x, of a box and those before it
};

Bounds bounds_of(const Surface& surface, const TriangleMesh& mesh) {
  Bounds bounds;
  for (const std::uint32_t t : surface.triangles)
    for (const std::uint32_t v : mesh.triangles[t]) bounds.add(mesh.vertices[v]);
  return bounds;
}

/// @return those to be turned, as `faces` has them; 0: none.
std::uint8_t wrong_side(const Surface& surface, const std::vector<std::uint8_t>& faces,
                        const TriangleMesh& mesh, const Boxes& boxes) {
  const std::size_t all = surface.triangles.size(), other = surface.facing_other;
  // Within another one it is a cavity or a solid: triangles that face both ways about as often do not say.
  if (boxes.may_be_enclosed(surface.triangles[0], bounds_of(surface, mesh)))
    return 4 * other <= all ? 2 : 4 * (all - other) <= all ? 1 : 0;
  return six_volumes(surface, faces, mesh) < 0.0 ? 1 : 2;
}

/// Where a surface bounds something, its triangles have to face one way.
void turn_to_one_side(const std::vector<std::uint32_t>& in_file, TriangleMesh& mesh, MeshReport& report) {
  Neighbours neighbours(mesh.triangles);
  const Boxes boxes(mesh, neighbours);
  std::vector<std::uint8_t> faces(mesh.triangles.size(), 0);
  for (std::uint32_t first = 0; first < mesh.triangles.size(); ++first) {
    if (faces[first] != 0) continue;
    const Surface surface = surface_from(first, neighbours, faces);
    if (!surface.may_be_turned || surface.facing_other == 0) continue;
    const std::uint8_t wrong = wrong_side(surface, faces, mesh, boxes);
    for (const std::uint32_t t : surface.triangles) {
      if (faces[t] != wrong) continue;
      std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
      report.triangles_turned.push_back(in_file[t]);
    }
  }
  std::sort(report.triangles_turned.begin(), report.triangles_turned.end());
}

std::size_t count_shells(const TriangleMesh& mesh) {
  DisjointSets joined = join_corners(mesh);
  std::vector<char> is_used(mesh.vertices.size(), 0);
  for (const Triangle& t : mesh.triangles) is_used[t[0]] = is_used[t[1]] = is_used[t[2]] = 1;
  std::size_t shells = 0;
  for (std::uint32_t v = 0; v < is_used.size(); ++v) shells += is_used[v] && joined.least_of(v) == v;
  return shells;
}

}  // namespace

LoadedMesh weld(const Soup& soup, const ReadTask& task) {
  LoadedMesh out;
  out.report.polygons_split = soup.polygons_split;
  const std::vector<std::uint32_t> in_file = take_triangles(soup, task, out);
  if (out.mesh.triangles.empty())
    task.fail(soup.triangles.empty() ? "no triangle" : "none of its triangles has an area");
  out.report.low = out.report.high = out.mesh.vertices[0];
  for (const Vector3& v : out.mesh.vertices) {
    out.report.low = out.report.low.cwiseMin(v);
    out.report.high = out.report.high.cwiseMax(v);
  }
  count_edges(out.mesh.triangles, in_file, out.report);
  if (!out.report.is_oriented()) {
    turn_to_one_side(in_file, out.mesh, out.report);
    if (!out.report.triangles_turned.empty()) count_edges(out.mesh.triangles, in_file, out.report);
  }
  out.report.shells = count_shells(out.mesh);
  return out;
}

}  // namespace touchstone::mesh_files
