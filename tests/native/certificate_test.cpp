#include "touchstone/contact_core/native/certificate.hpp"

#include <gmpxx.h>
#include <gtest/gtest.h>

#include <filesystem>

#ifdef TOUCHSTONE_HARD_CASES
#include "touchstone/adapters/scene_files/pair_file.hpp"
#endif
#include "touchstone/examples/measures/pairs/pair_families.hpp"
#include "touchstone/tests/native/native_fixture.hpp"

namespace touchstone {
namespace {

using Kind = OverlapCertificate::Kind;

// ---- The checker: world vertices, rational numbers, and the header's definitions.

struct Point {
  mpq_class x, y, z;
};

Point operator-(const Point& p, const Point& q) { return {p.x - q.x, p.y - q.y, p.z - q.z}; }
Point operator+(const Point& p, const Point& q) { return {p.x + q.x, p.y + q.y, p.z + q.z}; }
Point operator*(const mpq_class& s, const Point& p) { return {s * p.x, s * p.y, s * p.z}; }
mpq_class dot(const Point& p, const Point& q) { return p.x * q.x + p.y * q.y + p.z * q.z; }
Point cross(const Point& p, const Point& q) {
  return {p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x};
}

using Points = std::vector<Point>;  // 0-7 of A, 8-15 of B

Points exact_vertices(const Hexahedron& a, const Pose& X_WA, const Hexahedron& b, const Pose& X_WB) {
  Points out;
  for (const auto& [solid, X] : {std::pair{&a, &X_WA}, std::pair{&b, &X_WB}}) {
    for (const Vector3& v : solid->vertices()) {
      const Vector3 p = transform(*X, v);
      out.push_back({p.x(), p.y(), p.z()});
    }
  }
  return out;
}

bool separates(const Points& p, const Point& n) {
  for (int i = 0; i < 8; ++i)
    for (int j = 8; j < 16; ++j)
      if (dot(n, p[j] - p[i]) <= 0) return false;
  return true;
}

bool is_common_point(const Points& p, const std::array<std::uint8_t, 5>& vertices) {
  mpq_class sum_a, sum_b;
  Point point_a, point_b;
  bool a_not_negative = true, a_not_positive = true;
  for (int k = 0; k < 5; ++k) {
    std::vector<Point> other;
    for (int i = 0; i < 5; ++i)
      if (i != k) other.push_back(p[vertices[i]]);
    mpq_class c = dot(cross(other[1] - other[0], other[2] - other[0]), other[3] - other[0]);
    if (k % 2 == 1) c = -c;
    const bool of_a = vertices[k] < 8;
    (of_a ? sum_a : sum_b) += c;
    (of_a ? point_a : point_b) = (of_a ? point_a : point_b) + c * p[vertices[k]];
    a_not_negative = a_not_negative && (of_a ? c >= 0 : c <= 0);
    a_not_positive = a_not_positive && (of_a ? c <= 0 : c >= 0);
  }
  if (sum_a == 0 || sum_b == 0 || !(a_not_negative || a_not_positive)) return false;
  const Point difference = mpq_class(1 / sum_a) * point_a - mpq_class(1 / sum_b) * point_b;
  return difference.x == 0 && difference.y == 0 && difference.z == 0;
}

bool is_right(const OverlapCertificate& certificate, const Points& p) {
  switch (certificate.kind) {
    case Kind::separating_axis: {
      const Vector3& n = certificate.axis_W;
      return separates(p, {n.x(), n.y(), n.z()});
    }
    case Kind::separating_lines: {
      const auto& [u, v] = certificate.lines;
      return separates(p, cross(p[u[1]] - p[u[0]], p[v[1]] - p[v[0]]));
    }
    case Kind::common_point:
      return is_common_point(p, certificate.vertices);
    case Kind::none:
      return false;
  }
  return false;
}

/// The certificate, its confirmation, and native's answer.
Kind expect_certified(const Hexahedron& a, const Pose& X_WA, const Hexahedron& b, const Pose& X_WB) {
  const OverlapCertificate certificate = certify_overlap(a, X_WA, b, X_WB);
  EXPECT_TRUE(is_right(certificate, exact_vertices(a, X_WA, b, X_WB))) << static_cast<int>(certificate.kind);
  EXPECT_EQ(certificate.kind == Kind::common_point,
            ask(a, X_WA, b, X_WB, QueryKind::overlap).status == PairStatus::overlapping);
  return certificate.kind;
}

TEST(NativeCertificate, OfEveryFamilyIsConfirmed) {
  std::array<int, 4> kinds{};
  for (const measures::PairFamily& family : measures::pair_families()) {
    SCOPED_TRACE(family.name);
    const measures::PairSet set = measures::make_pair_family(family.name, 5, 60);
    for (const SolidPair& pair : set.pairs)
      ++kinds[static_cast<std::size_t>(
          expect_certified(set.solids[pair.a], set.poses[pair.a], set.solids[pair.b], set.poses[pair.b]))];
  }
  EXPECT_GT(kinds[static_cast<std::size_t>(Kind::separating_axis)], 100);
  EXPECT_GT(kinds[static_cast<std::size_t>(Kind::separating_lines)], 0);
  EXPECT_GT(kinds[static_cast<std::size_t>(Kind::common_point)], 100);
  EXPECT_EQ(kinds[static_cast<std::size_t>(Kind::none)], 0);
}

#ifdef TOUCHSTONE_HARD_CASES
TEST(NativeCertificate, OfEveryHardCaseIsConfirmed) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(TOUCHSTONE_HARD_CASES)) {
    if (entry.path().extension() != ".json") continue;
    for (const PairCase& item : load_pairs(entry.path())) {
      if (!item.pair) continue;  // what a reader must refuse
      SCOPED_TRACE(item.id);
      const auto& [solids, X_W] = *item.pair;
      const Kind kind = expect_certified(solids[0], X_W[0], solids[1], X_W[1]);
      EXPECT_EQ(kind == Kind::common_point, item.exact->pair_class != PairClass::separated);
      ++count;
    }
  }
  EXPECT_GE(count, 80);
}
#endif

TEST(NativeCertificate, OfSolidsOfAllKindsWithinAnUlpOfTouchingIsConfirmed) {
  Random random(31);
  for (int i = 0; i < 150; ++i) {
    SCOPED_TRACE(i);
    const Hexahedron a = random.any(), b = random.any();
    const Pose X_WA = random.pose(0.3);
    Pose X_WB = random.pose(1.2);
    const PairGeometry g = ask(a, X_WA, b, X_WB, QueryKind::distance).geometry;
    X_WB.p -= g.separation * g.n_AB_W;
    expect_certified(a, X_WA, b, X_WB);
  }
}

TEST(NativeCertificate, OfTouchingAndScaledCubesIsConfirmed) {
  const double above = std::nextafter(1.0, 2.0);
  for (const double k : {1.0, 0x1p-900, 0x1p900, 0x1p-1040}) {
    const Hexahedron cube = Hexahedron::from_size(Vector3::Constant(k));
    for (const Vector3& p : {Vector3(1, 0, 0), Vector3(1, 1, 0), Vector3(1, 1, 1), Vector3(1, 0.5, -1)}) {
      SCOPED_TRACE(k);
      EXPECT_EQ(expect_certified(cube, at(0, 0, 0), cube, at(k * p.x(), k * p.y(), k * p.z())),
                Kind::common_point);
      if (k > 0x1p-1000) {  // else there is no number between
        EXPECT_NE(expect_certified(cube, at(0, 0, 0), cube, at(k * p.x() * above, k * p.y(), k * p.z())),
                  Kind::common_point);
      }
    }
  }
}

TEST(NativeCertificate, TheCheckerRefusesWhatIsWrong) {
  const Hexahedron cube = Hexahedron::from_size({1, 1, 1});
  const Points meeting = exact_vertices(cube, at(0, 0, 0), cube, at(0.5, 0.25, 0.125));
  const Points apart = exact_vertices(cube, at(0, 0, 0), cube, at(3, 0.25, 0.125));
  OverlapCertificate certificate = certify_overlap(cube, at(0, 0, 0), cube, at(0.5, 0.25, 0.125));
  EXPECT_TRUE(is_right(certificate, meeting));
  EXPECT_FALSE(is_right(certificate, apart));
  certificate = certify_overlap(cube, at(0, 0, 0), cube, at(3, 0.25, 0.125));
  EXPECT_TRUE(is_right(certificate, apart));
  EXPECT_FALSE(is_right(certificate, meeting));
  certificate.axis_W = -certificate.axis_W;
  EXPECT_FALSE(is_right(certificate, apart));
}

}  // namespace
}  // namespace touchstone
