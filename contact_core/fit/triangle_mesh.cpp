#include "touchstone/contact_core/fit/triangle_mesh.hpp"

#include <algorithm>
#include <utility>

#include "touchstone/contact_core/fit/meshes/places.hpp"
#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

constexpr double kLargestCoordinate = 1e70;  // fourth powers stay finite: squares of areas

// An edge with its lower vertex first; `turn` is +1 where the triangle runs up, else -1.
struct DirectedEdge {
  std::uint32_t low, high;
  int turn;
  std::uint32_t shell;
};

std::vector<DirectedEdge> sorted_edges(const TriangleMesh& mesh, const MeshShells& shells) {
  std::vector<DirectedEdge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t a = mesh.triangles[t][i], b = mesh.triangles[t][(i + 1) % 3];
      if (a != b)
        edges.push_back({std::min(a, b), std::max(a, b), a < b ? 1 : -1, shells.shell_of_triangle[t]});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const DirectedEdge& a, const DirectedEdge& b) {
    return std::pair(a.low, a.high) < std::pair(b.low, b.high);
  });
  return edges;
}

}  // namespace

void validate(const TriangleMesh& mesh, std::string_view name) {
  if (mesh.triangles.empty()) reject(name, "no triangle");
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t corner : mesh.triangles[t]) {
      const std::string where = "triangle " + std::to_string(t) + ": ";
      if (corner >= mesh.vertices.size())
        reject(name, where + "vertex " + std::to_string(corner) + " of " +
                         std::to_string(mesh.vertices.size()) + " does not exist");
      for (int axis = 0; axis < 3; ++axis) {
        const double value = mesh.vertices[corner](axis);
        if (!(std::abs(value) <= kLargestCoordinate))
          reject(name, where + "coordinate " + figure(value) + " is not finite or beyond 1e70");
      }
    }
  }
}

TriangleMesh weld(const TriangleMesh& mesh) {
  Places places(mesh.vertices.size());
  std::vector<Vector3> distinct;
  std::vector<std::uint32_t> place_of(mesh.vertices.size());
  for (std::size_t i = 0; i < place_of.size(); ++i) place_of[i] = places.index_of(mesh.vertices[i], distinct);
  std::vector<std::uint32_t> number(distinct.size(), kNoIndex);  // by first use
  TriangleMesh welded;
  for (const auto& corners : mesh.triangles) {
    std::array<std::uint32_t, 3> joined{};
    for (int i = 0; i < 3; ++i) {
      std::uint32_t& at = number[place_of[corners[i]]];
      if (at == kNoIndex) {
        at = static_cast<std::uint32_t>(welded.vertices.size());
        welded.vertices.push_back(distinct[place_of[corners[i]]]);
      }
      joined[i] = at;
    }
    welded.triangles.push_back(joined);
  }
  return welded;
}

MeshShells find_shells(const TriangleMesh& mesh) {
  DisjointSets joined = join_corners(mesh);
  std::vector<std::uint32_t> number(mesh.vertices.size(), kNoIndex);
  MeshShells shells;
  for (const auto& corners : mesh.triangles) {
    std::uint32_t& shell = number[joined.least_of(corners[0])];
    if (shell == kNoIndex) {
      shell = static_cast<std::uint32_t>(shells.is_closed.size());
      shells.is_closed.push_back(1);
    }
    shells.shell_of_triangle.push_back(shell);
  }
  const std::vector<DirectedEdge> edges = sorted_edges(mesh, shells);
  for (std::size_t i = 0; i < edges.size();) {
    int turns = 0;
    std::size_t end = i;
    for (; end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high; ++end)
      turns += edges[end].turn;
    if (turns != 0) shells.is_closed[edges[i].shell] = 0;
    shells.open_edges += static_cast<std::size_t>(std::abs(turns));
    i = end;
  }
  return shells;
}

}  // namespace touchstone
