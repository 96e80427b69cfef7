#include "touchstone/adapters/robots/enclosing_box.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/geometry/norms.hpp"
#include "touchstone/contact_core/geometry/orientation.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

constexpr int kMostTurns = 30;
constexpr double kWorthTurning = 0.99;
constexpr int kCells = 12;  // along the longest side
constexpr std::size_t kMostTriangles = 2000;

/// The least interval of each of a frame's axes that holds all vertices.
struct Extent {
  Vector3 low, high;

  Vector3 size() const { return high - low; }
  double volume() const { return size().x() * size().y() * size().z(); }
};

Extent extent(const std::vector<Vector3>& vertices, const Matrix3& R) {
  Extent out{Vector3::Constant(kInfinity), Vector3::Constant(-kInfinity)};
  for (const Vector3& v : vertices) {
    const Vector3 p = rotate_back(R, v);
    out.low = out.low.cwiseMin(p);
    out.high = out.high.cwiseMax(p);
  }
  return out;
}

struct Point2 {
  double x, y;
  bool operator<(const Point2& other) const { return x != other.x ? x < other.x : y < other.y; }
};

double turn(const Point2& a, const Point2& b, const Point2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// Counter-clockwise (Andrew's monotone chain). Rounding may leave out a point that is on it: the box found
/// is checked by itself.
std::vector<Point2> hull_of(std::vector<Point2> points) {
  std::sort(points.begin(), points.end());
  std::vector<Point2> hull;
  const auto add = [&](const Point2& p, std::size_t fixed) {
    while (hull.size() >= fixed + 2 && turn(hull[hull.size() - 2], hull.back(), p) <= 0.0) hull.pop_back();
    hull.push_back(p);
  };
  for (const Point2& p : points) add(p, 0);
  hull.pop_back();
  const std::size_t lower = hull.size();
  for (auto p = points.rbegin(); p != points.rend(); ++p) add(*p, lower);
  hull.pop_back();
  return hull;
}

/// The direction of the hull's edge along which the rectangle around it is least.
Point2 best_edge(const std::vector<Point2>& hull) {
  Point2 best{1.0, 0.0};
  double least = kInfinity;
  // Long outlines are judged by every n-th edge: the search only has to find a good box.
  const std::size_t every = 1 + hull.size() / 500;
  for (std::size_t i = 0; i < hull.size(); i += every) {
    const Point2& a = hull[i];
    const Point2& b = hull[(i + 1) % hull.size()];
    const double length = std::sqrt((b.x - a.x) * (b.x - a.x) + (b.y - a.y) * (b.y - a.y));
    if (!(length > 0.0)) continue;
    const Point2 u{(b.x - a.x) / length, (b.y - a.y) / length};
    double low = 0.0, high = 0.0, height = 0.0;
    for (const Point2& p : hull) {
      const double along = u.x * (p.x - a.x) + u.y * (p.y - a.y);
      low = std::min(low, along), high = std::max(high, along);
      height = std::max(height, u.x * (p.y - a.y) - u.y * (p.x - a.x));
    }
    if ((high - low) * height < least) least = (high - low) * height, best = u;
  }
  return best;
}

/// The frame turned about its axis `k` to the least rectangle.
Matrix3 turned_about(const std::vector<Vector3>& vertices, const Matrix3& R, int k) {
  const Vector3 u = R.col((k + 1) % 3), v = R.col((k + 2) % 3), w = R.col(k);
  std::vector<Point2> points;
  points.reserve(vertices.size());
  for (const Vector3& p : vertices) points.push_back({dot(u, p), dot(v, p)});
  const std::vector<Point2> hull = hull_of(std::move(points));
  if (hull.size() < 3) return R;
  const Point2 edge = best_edge(hull);
  Vector3 x = edge.x * u + edge.y * v;
  x = x / norm(x);
  Vector3 y = cross(w, x);
  y = y / norm(y);
  Matrix3 out;
  out.col(0) = x, out.col(1) = y, out.col(2) = cross(x, y);
  return out;
}

Matrix3 best_frame(const std::vector<Vector3>& vertices) {
  Matrix3 R = Matrix3::Identity();
  const double along_axes = extent(vertices, R).volume();
  double least = along_axes;
  for (int turns = 0, without_gain = 0; turns < kMostTurns && without_gain < 3; ++turns) {
    const Matrix3 next = turned_about(vertices, R, turns % 3);
    const double volume = extent(vertices, next).volume();
    const bool gains = volume < kWorthTurning * least;
    without_gain = gains ? 0 : without_gain + 1;
    if (gains) R = next, least = volume;
  }
  return R;
}

bool holds(const PlacedHexahedron& box, const std::vector<Vector3>& points) {
  std::array<Vector3, 8> v;
  for (int i = 0; i < 8; ++i) v[i] = transform(box.X_OS, box.solid.vertices()[i]);
  // Rounding bends faces: a point within both halves of each, cut either way, is within the hull.
  constexpr std::array<std::array<int, 3>, 4> kHalves = {{{0, 1, 2}, {0, 2, 3}, {0, 1, 3}, {1, 2, 3}}};
  return std::all_of(points.begin(), points.end(), [&](const Vector3& p) {
    return std::all_of(
        Hexahedron::kFaceVertices.begin(), Hexahedron::kFaceVertices.end(), [&](const auto& face) {
          return std::all_of(kHalves.begin(), kHalves.end(), [&](const auto& half) {
            return numerics::orient3d_sign(v[face[half[0]]], v[face[half[1]]], v[face[half[2]]], p) <= 0;
          });
        });
  });
}

PlacedHexahedron box_around(const std::vector<Vector3>& vertices, const std::string& name) {
  const Matrix3 R = best_frame(vertices);
  const Extent around = extent(vertices, R);
  const Vector3 centre = 0.5 * (around.low + around.high);
  const double scale = std::max(norm_inf(around.low), norm_inf(around.high));
  double margin = 0x1p-50 * scale;  // of a few roundings; seldom enough at once
  for (int doublings = 0; doublings < 30; ++doublings, margin *= 2.0) {
    const Vector3 size = around.size() + Vector3::Constant(2.0 * margin);
    PlacedHexahedron box{name, Hexahedron::from_size(size, name), {R, rotate(R, centre)}};
    if (holds(box, vertices)) return box;
  }
  throw InputError(name + ": no box of doubles holds the mesh: its coordinates are up to " + figure(scale));
}

/// Ericson, Real-Time Collision Detection (2005), 5.1.5: by the regions of the triangle's corners and edges.
double distance(const Vector3& p, const std::array<Vector3, 3>& t) {
  const Vector3 ab = t[1] - t[0], ac = t[2] - t[0], ap = p - t[0];
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0.0 && d2 <= 0.0) return norm(ap);
  const Vector3 bp = p - t[1];
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0.0 && d4 <= d3) return norm(bp);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return norm(ap - d1 / (d1 - d3) * ab);
  const Vector3 cp = p - t[2];
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0.0 && d5 <= d6) return norm(cp);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return norm(ap - d2 / (d2 - d6) * ac);
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0)
    return norm(bp - (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (t[2] - t[1]));
  const double sum = va + vb + vc;
  return norm(ap - vb / sum * ab - vc / sum * ac);
}

double error_bound(const TriangleMesh& mesh, const PlacedHexahedron& box) {
  // Some of the triangles are enough: fewer make the bound larger, never too small.
  std::vector<std::array<Vector3, 3>> triangles;
  const std::size_t every = 1 + mesh.triangles.size() / kMostTriangles;
  for (std::size_t i = 0; i < mesh.triangles.size(); i += every) {
    const auto& t = mesh.triangles[i];
    triangles.push_back({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
  }
  // The box is divided into cells that are nearly cubes.
  const Vector3 half = box.solid.half_extents();
  std::array<int, 3> cells{};
  Vector3 cell;
  for (int i = 0; i < 3; ++i) {
    cells[i] = std::max(1, static_cast<int>(std::ceil(kCells * half[i] / half.maxCoeff())));
    cell[i] = 2.0 * half[i] / cells[i];
  }
  // No point of a cell is farther off than its centre and half its diagonal.
  double farthest = 0.0;
  for (int i = 0; i < cells[0]; ++i)
    for (int j = 0; j < cells[1]; ++j)
      for (int k = 0; k < cells[2]; ++k) {
        const Vector3 centre = Vector3(i + 0.5, j + 0.5, k + 0.5).cwiseProduct(cell) - half;
        const Vector3 p = transform(box.X_OS, centre);
        double nearest = kInfinity;
        for (const auto& t : triangles) nearest = std::min(nearest, distance(p, t));
        farthest = std::max(farthest, nearest);
      }
  return (farthest + 0.5 * norm(cell)) * (1.0 + 0x1p-30);  // far more than what was rounded
}

}  // namespace

MeshCover enclosing_box(const TriangleMesh& mesh, const std::string& name) {
  MeshCover cover;
  cover.solids.push_back(box_around(mesh.vertices, name));
  cover.error = error_bound(mesh, cover.solids[0]);
  return cover;
}

}  // namespace touchstone
