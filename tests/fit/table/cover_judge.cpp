#include "touchstone/tests/fit/table/cover_judge.hpp"

#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btTriangleMesh.h>
#include <BulletCollision/NarrowPhaseCollision/btRaycastCallback.h>
#include <LinearMath/btGeometryUtil.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "touchstone/contact_core/fit/mesh_distance.hpp"

namespace touchstone::test {
namespace {

constexpr double kSamplesALine = 4.0;  // inside, on average
constexpr int kPilotLines = 3000;      // measure the volume

// Bullet's utilities take a hundredth for nothing: coordinates of 2^33 make that 2^-40 of them.
constexpr int kBulletExponent = 33;

btVector3 to_bullet(const Vector3& p) { return {p.x(), p.y(), p.z()}; }

double largest_coordinate(const TriangleMesh& mesh) {
  double largest = 0.0;
  for (const Vector3& p : mesh.vertices) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  return largest;
}

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double next() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }  // [0, 1)

 private:
  std::mt19937_64 engine_;
};

struct Crossing {
  double fraction;  // of the ray
  int turn;         // +1 into a shell
};

struct AllCrossings : btTriangleRaycastCallback {
  AllCrossings(const btVector3& from, const btVector3& to)
      : btTriangleRaycastCallback(from, to, kF_KeepUnflippedNormal), along(to - from) {}
  btScalar reportHit(const btVector3& normal, btScalar fraction, int, int) override {
    crossings.push_back({fraction, normal.dot(along) < 0.0 ? 1 : -1});
    return m_hitFraction;  // goes on to the end
  }
  btVector3 along;
  std::vector<Crossing> crossings;
};

// Pieces as planes, in Bullet's scale.
class Pieces {
 public:
  Pieces(std::span<const ConvexPiece> pieces, double largest, double tolerance) {
    scale_ = std::ldexp(1.0, kBulletExponent - std::ilogb(largest));
    margin_ = tolerance * largest * scale_;
    for (const ConvexPiece& piece : pieces) add(piece);
  }

  bool hold(const Vector3& p) {
    const btVector3 scaled = to_bullet(scale_ * p);
    for (std::size_t i = 0; i < all_.size(); ++i) {
      const std::size_t at = (last_ + i) % all_.size();  // samples that are near come after each other
      const Piece& piece = all_[at];
      if (!is_near(piece, scaled)) continue;
      if (!btGeometryUtil::isPointInsidePlanes(piece.planes, scaled, margin_)) continue;
      last_ = at;
      return true;
    }
    return false;
  }

 private:
  struct Piece {
    btVector3 low, high;
    btAlignedObjectArray<btVector3> planes;
  };

  bool is_near(const Piece& piece, const btVector3& p) const {
    for (int axis = 0; axis < 3; ++axis)
      if (p[axis] < piece.low[axis] - margin_ || p[axis] > piece.high[axis] + margin_) return false;
    return true;
  }

  void add(const ConvexPiece& piece) {
    btAlignedObjectArray<btVector3> vertices;
    Piece made{to_bullet(scale_ * piece.vertices[0]), to_bullet(scale_ * piece.vertices[0]), {}};
    for (const Vector3& v : piece.vertices) {
      vertices.push_back(to_bullet(scale_ * v));
      made.low.setMin(vertices[vertices.size() - 1]);
      made.high.setMax(vertices[vertices.size() - 1]);
    }
    if (piece.triangles.empty())
      btGeometryUtil::getPlaneEquationsFromVertices(vertices, made.planes);
    else
      add_facets(piece, vertices, made.planes);
    if (made.planes.size() >= 4) all_.push_back(made);  // fewer bound nothing
  }

  static void add_facets(const ConvexPiece& piece, const btAlignedObjectArray<btVector3>& vertices,
                         btAlignedObjectArray<btVector3>& planes) {
    btVector3 middle(0, 0, 0);
    for (int i = 0; i < vertices.size(); ++i) middle += vertices[i] / vertices.size();
    for (const auto& t : piece.triangles) {
      const btVector3& a = vertices[static_cast<int>(t[0])];
      btVector3 normal = (vertices[static_cast<int>(t[1])] - a).cross(vertices[static_cast<int>(t[2])] - a);
      if (normal.length2() == 0.0) continue;
      normal.normalize();
      if (normal.dot(middle - a) > 0.0) normal = -normal;
      normal[3] = -normal.dot(a);
      planes.push_back(normal);
    }
  }

  double scale_ = 1.0, margin_ = 0.0;
  std::vector<Piece> all_;
  std::size_t last_ = 0;
};

}  // namespace

struct CoverJudge::Rays {
  explicit Rays(const TriangleMesh& mesh) {
    const TriangleMesh welded = weld(mesh);
    const MeshShells shells = find_shells(welded);
    for (std::size_t t = 0; t < welded.triangles.size(); ++t) {
      if (shells.is_closed[shells.shell_of_triangle[t]] == 0) continue;
      const auto& corners = welded.triangles[t];
      for (const std::uint32_t i : corners) bounds.add(welded.vertices[i]);
      triangles.addTriangle(to_bullet(welded.vertices[corners[0]]), to_bullet(welded.vertices[corners[1]]),
                            to_bullet(welded.vertices[corners[2]]));
    }
    if (triangles.getNumTriangles() > 0)
      shape = std::make_unique<btBvhTriangleMeshShape>(&triangles, /*useQuantizedAabbCompression=*/false);
  }

  /// A line through the box along an axis, and where it is inside: pairs of coordinates along it.
  struct Line {
    Vector3 start;
    int axis;
    std::vector<std::pair<double, double>> inside;
    double length = 0.0;
    bool is_dropped = false;
  };

  Line random_line(int axis, Random& random) const {
    // A line along the axis, from before the mesh to behind it.
    const Vector3 margin = Vector3::Constant(0.01 * bounds.diagonal());
    const Vector3 low = bounds.low - margin, high = bounds.high + margin;
    Line line{bounds.low, axis, {}};
    for (int i = 0; i < 3; ++i)
      if (i != axis) line.start(i) += random.next() * (bounds.high(i) - bounds.low(i));
    Vector3 from = line.start, to = line.start;
    from(axis) = low(axis);
    to(axis) = high(axis);
    // All triangles that it crosses, in order.
    AllCrossings crossings(to_bullet(from), to_bullet(to));
    shape->performRaycast(&crossings, to_bullet(from), to_bullet(to));
    std::sort(crossings.crossings.begin(), crossings.crossings.end(),
              [](const Crossing& a, const Crossing& b) { return a.fraction < b.fraction; });
    // Inside is where the winding number is not zero.
    int winding = 0;
    double last = 0.0;
    for (const Crossing& crossing : crossings.crossings) {
      const double at = low(axis) + crossing.fraction * (high(axis) - low(axis));
      if (winding != 0) {
        line.inside.emplace_back(last, at);
        line.length += at - last;
      }
      winding += crossing.turn;
      last = at;
    }
    line.is_dropped = winding != 0;
    return line;
  }

  /// By most of five rays in random directions.
  bool is_inside(const Vector3& p, Random& random) const {
    int votes = 0;
    for (int i = 0; i < 5; ++i) {
      const Vector3 direction(random.next() - 0.5, random.next() - 0.5, random.next() - 0.5);
      const Vector3 to = p + 4.0 * bounds.diagonal() / norm(direction) * direction;
      AllCrossings crossings(to_bullet(p), to_bullet(to));
      shape->performRaycast(&crossings, to_bullet(p), to_bullet(to));
      int winding = 0;
      for (const Crossing& crossing : crossings.crossings) winding -= crossing.turn;
      votes += winding != 0 ? 1 : 0;
    }
    return votes >= 3;
  }

  Bounds bounds;
  btTriangleMesh triangles{true, false};
  std::unique_ptr<btBvhTriangleMeshShape> shape;
};

CoverJudge::CoverJudge(const TriangleMesh& mesh) : mesh_(mesh), rays_(std::make_unique<Rays>(mesh)) {}
CoverJudge::~CoverJudge() = default;

namespace {

// By area: which triangle, then where on it.
void judge_surface(const TriangleMesh& mesh, Pieces& pieces, std::size_t samples, Random& random,
                   const std::function<void(double)>& progress, JudgedSamples& out) {
  std::vector<double> sums;
  double sum = 0.0;
  for (const auto& t : mesh.triangles) {
    const Vector3 a = mesh.vertices[t[0]];
    sums.push_back(sum += norm(cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a)));
  }
  // Triangles in their order, each with its share: samples that are near come after each other.
  const double step = sum / static_cast<double>(samples);
  double at = random.next() * step;
  for (std::size_t t = 0; t < sums.size(); ++t) {
    const auto& corners = mesh.triangles[t];
    for (; at < sums[t] && out.surface < samples; at += step) {
      const double root = std::sqrt(random.next()), share = random.next();
      const Vector3 p = (1.0 - root) * mesh.vertices[corners[0]] +
                        root * (1.0 - share) * mesh.vertices[corners[1]] +
                        root * share * mesh.vertices[corners[2]];
      ++out.surface;
      if (!pieces.hold(p)) ++out.uncovered_surface, out.an_uncovered = p;
      if (progress && out.surface % 65536 == 0) progress(at / sum);
    }
  }
}

}  // namespace

JudgedSamples CoverJudge::judge(std::span<const ConvexPiece> pieces, std::size_t samples, std::uint64_t seed,
                                double tolerance, const std::function<void(double)>& progress) const {
  // How many samples go inside, and how far they are apart on lines.
  Pieces planes(pieces, largest_coordinate(mesh_), tolerance);
  Random random(seed);
  JudgedSamples out;
  double length = 0.0;
  if (rays_->shape)
    for (int i = 0; i < kPilotLines; ++i) length += rays_->random_line(i % 3, random).length / kPilotLines;
  const std::size_t inside = length > 0.0 ? samples / 2 : 0;
  // On the surface.
  judge_surface(mesh_, planes, samples - inside, random, progress, out);
  const double step = length / kSamplesALine;
  // Inside, along lines at random.
  for (int axis = 0; out.inside < inside; axis = (axis + 1) % 3) {
    const Rays::Line line = rays_->random_line(axis, random);
    if (line.is_dropped) {
      ++out.dropped_lines;
      continue;
    }
    double at = random.next() * step;
    for (const auto& [from, to] : line.inside) {
      for (; at < to - from && out.inside < inside; at += step) {
        Vector3 p = line.start;
        p(axis) = from + at;
        ++out.inside;
        if (!planes.hold(p) && rays_->is_inside(p, random)) ++out.uncovered_inside, out.an_uncovered = p;
        if (progress && out.inside % 65536 == 0)
          progress(static_cast<double>(out.inside) / static_cast<double>(inside));
      }
      at -= to - from;
    }
  }
  return out;
}

}  // namespace touchstone::test
