#include "touchstone/tests/proof/checks/narrowphase_checks.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "touchstone/adapters/exact/signed_distance.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/norms.hpp"
#include "touchstone/tests/proof/checks/result_bits.hpp"
#include "touchstone/tests/proof/pairs/pair_text.hpp"

namespace touchstone::proof {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

struct Answer {
  PairStatus status = PairStatus::failed;
  PairGeometry geometry{};
  std::array<ContactPoint, kMaxManifoldPoints> points{};
};

std::vector<std::uint64_t> bits(const Answer& answer, QueryKind kind) {
  if (kind == QueryKind::overlap) return {static_cast<std::uint64_t>(answer.status)};
  std::vector<std::uint64_t> words;
  for_each_word(answer.status, answer.geometry, answer.points,
                [&](std::uint64_t word) { words.push_back(word); });
  return words;
}

Hexahedron leaning_block() {
  std::array<Vector3, 8> v;
  for (int i = 0; i < 8; ++i)
    v[i] = {i & 4 ? 1.0 : -1.0, i & 2 ? 0.5 : -0.5, (i & 1 ? 0.75 : -0.75) + (i & 4 ? 0.25 : 0.0)};
  return Hexahedron::from_vertices(v);
}

Hexahedron lifted_block() {
  std::array<Vector3, 8> v;
  for (int i = 0; i < 8; ++i) v[i] = {i & 4 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, i & 1 ? 1.0 : -1.0};
  v[7].z() = 1.5;
  return Hexahedron::from_vertices(v, WarpPolicy::accept);
}

/// The pair as solids 0 and 1, and again as 5 (b) and 6 (a); between them a box, a parallelepiped and a
/// warped solid.
class Bench {
 public:
  Bench(const PosedSolids& solids, Narrowphase& narrowphase) : narrowphase_(narrowphase) {
    const Hexahedron box = Hexahedron::from_size({1, 2, 0.5});
    const std::array built = {solids.a, solids.b, box, leaning_block(), lifted_block(), solids.b, solids.a};
    poses_ = {solids.X_WA, solids.X_WB, Pose{}, Pose{}, Pose{}, solids.X_WB, solids.X_WA};
    poses_[3].p = {0.5, 1.0, 0.25}, poses_[4].p = {0.25, -0.5, 2.125};
    narrowphase_.build(built);
    workspace_ = narrowphase_.make_workspace();
  }

  Answer ask(SolidPair pair, const Query& query) const {
    Answer answer;
    const std::array pairs = {pair};
    narrowphase_.evaluate({.pairs = pairs, .poses = poses_, .query = query},
                          {{&answer.status, 1}, {&answer.geometry, 1}, answer.points}, *workspace_);
    return answer;
  }

  /// The pair at every third place of a batch among others, twice with one cache.
  std::vector<Answer> ask_in_batches(const Query& query) const {
    constexpr std::array<SolidPair, 6> kOthers = {{{2, 3}, {0, 2}, {3, 4}, {1, 4}, {2, 4}, {5, 6}}};
    constexpr std::size_t kCount = 19;
    std::array<SolidPair, kCount> pairs;
    for (std::size_t i = 0; i < kCount; ++i) pairs[i] = i % 3 == 0 ? SolidPair{0, 1} : kOthers[i % 6];
    std::array<PairCacheEntry, kCount> cache{};
    std::array<PairStatus, kCount> status{};
    std::array<PairGeometry, kCount> geometry{};
    std::array<ContactPoint, kCount * kMaxManifoldPoints> points{};
    std::vector<Answer> answers;
    for (int pass = 0; pass < 3; ++pass) {
      NarrowphaseInput input{.pairs = pairs, .poses = poses_, .query = query};
      if (pass > 0) input.cache = cache;
      narrowphase_.evaluate(input, {status, geometry, points}, *workspace_);
      for (std::size_t i = 0; i < kCount; i += 3) {
        Answer& answer = answers.emplace_back();
        answer.status = status[i], answer.geometry = geometry[i];
        const auto slots = static_cast<std::size_t>(query.max_points);
        std::copy_n(points.begin() + static_cast<std::ptrdiff_t>(i * slots), slots, answer.points.begin());
      }
    }
    return answers;
  }

 private:
  Narrowphase& narrowphase_;
  std::array<Pose, 7> poses_;
  std::unique_ptr<Narrowphase::Workspace> workspace_;
};

class Checker {
 public:
  Checker(const PosedSolids& solids, Narrowphase& narrowphase) : bench_(solids, narrowphase) {
    world_vertices(solids.a, solids.X_WA, a_W_);
    world_vertices(solids.b, solids.X_WB, b_W_);
    S_ = std::max({solids.a.size(), solids.b.size(), largest_coordinate(a_W_), largest_coordinate(b_W_)});
    same_ = a_W_.x == b_W_.x && a_W_.y == b_W_.y && a_W_.z == b_W_.z;
    exact_ = exact_signed_distance(a_W_, b_W_);
  }

  CheckedPair run() {
    for (const QueryKind kind : {QueryKind::overlap, QueryKind::distance, QueryKind::manifold})
      check_query(kind);
    check_geometry(bench_.ask({0, 1}, {.kind = QueryKind::distance}).geometry);
    for (const double limit : {0.0, 1e-3 * S_, kInfinity}) {
      check_manifold({.kind = QueryKind::manifold, .max_point_separation = limit});
      check_manifold({.kind = QueryKind::manifold, .max_points = 3, .max_point_separation = limit});
    }
    check_limits();
    return std::move(out_);
  }

 private:
  void expect(bool kept, const std::string& promise, const std::string& found) {
    if (!kept) out_.failures.push_back(promise + ": " + found);
  }

  bool contact() const { return exact_.pair_class != PairClass::separated; }

  void check_query(QueryKind kind) {
    const std::string query = std::string(to_string(kind)) + " query: ";
    const Answer ab = bench_.ask({0, 1}, {.kind = kind}), ba = bench_.ask({5, 6}, {.kind = kind});
    const PairStatus right = contact() ? PairStatus::overlapping : PairStatus::separated;
    expect(ab.status == right, query + "status " + std::string(to_string(right)),
           std::string(to_string(ab.status)) + ", exact distance " + all_digits(exact_.separation));
    expect(ba.status == ab.status, query + "(b,a) has the status of (a,b)",
           std::string(to_string(ba.status)));
    if (kind != QueryKind::overlap) check_symmetry(query, ab.geometry, ba.geometry);
    const auto alone = bits(ab, kind);
    for (const Answer& in_batch : bench_.ask_in_batches({.kind = kind})) {
      if (bits(in_batch, kind) == alone) continue;
      expect(false, query + "a batch gives the bits of a single pair",
             all_digits(in_batch.geometry.separation) + " against " + all_digits(ab.geometry.separation));
      return;
    }
  }

  void check_symmetry(const std::string& query, const PairGeometry& ab, const PairGeometry& ba) {
    expect(std::bit_cast<std::uint64_t>(ab.separation) == std::bit_cast<std::uint64_t>(ba.separation),
           query + "(b,a) has the separation of (a,b)",
           all_digits(ab.separation) + " and " + all_digits(ba.separation));
    // Nothing tells two solids with the same vertices apart.
    expect(same_ || ab.n_AB_W == -ba.n_AB_W, query + "(b,a) has the negated normal of (a,b)",
           shown(ab.n_AB_W) + " and " + shown(ba.n_AB_W));
    expect(ab.point_count == ba.point_count, query + "(b,a) has as many points as (a,b)",
           std::to_string(ab.point_count) + " and " + std::to_string(ba.point_count));
  }

  void check_geometry(const PairGeometry& g) {
    expect((g.separation > 0) == !contact(), "separation > 0 just where the pair is apart",
           all_digits(g.separation));
    out_.separation_error = std::abs(g.separation - exact_.separation) / S_;
    expect(std::abs(g.separation - exact_.separation) <= kSeparationBound * S_ + kLeast,
           "separation within 1e-14 S of " + all_digits(exact_.separation),
           all_digits(g.separation) + ", off by " + all_digits(out_.separation_error) + " S");
    expect(std::abs(norm(g.n_AB_W) - 1.0) <= 4 * kEpsilon, "a unit normal", shown(g.n_AB_W));
    const double along = exact_separation_along(a_W_, b_W_, g.n_AB_W);
    out_.normal_error = std::abs(along - exact_.separation) / S_;
    expect(std::abs(along - exact_.separation) <= kSeparationBound * S_ + kLeast,
           "along the normal the pair is within 1e-14 S of " + all_digits(exact_.separation),
           all_digits(along) + ", off by " + all_digits(out_.normal_error) + " S");
    check_relation("witness points", g.p_A_W, g.p_B_W, g.separation, g.n_AB_W, 4 * kEpsilon);
    out_.witness_error =
        std::max(exact_surface_distance(a_W_, g.p_A_W), exact_surface_distance(b_W_, g.p_B_W)) / S_;
  }

  /// p_B = p_A + s n; `bound` over S: p_B is one sum of three rounded terms a coordinate.
  void check_relation(const std::string& what, const Vector3& p_A, const Vector3& p_B, double s,
                      const Vector3& n, double bound) {
    const Vector3 off = p_B - (p_A + s * n);
    const double largest = norm_inf(off);
    expect(largest <= bound * S_ + kLeast, what + ": p_B = p_A + separation n",
           "off by " + all_digits(largest / S_) + " S");
  }

  void check_manifold(const Query& query) {
    const Answer answer = bench_.ask({0, 1}, query);
    const int max_points = query.max_points;
    const PairGeometry& g = answer.geometry;
    expect(g.point_count >= 1 && g.point_count <= max_points,
           "1 to " + std::to_string(max_points) + " points", std::to_string(g.point_count));
    const int count = std::clamp(g.point_count, 0, max_points);
    double deepest = kInfinity;
    for (int i = 0; i < count; ++i) {
      const ContactPoint& point = answer.points[i];
      deepest = std::min(deepest, point.separation);
      // As near as the pair to rounding counts as within.
      expect(
          point.separation <= std::max(query.max_point_separation, g.separation + 4 * kSeparationBound * S_),
          "no point beyond the limit", all_digits(point.separation));
      check_relation("point " + std::to_string(i), point.p_A_W, point.p_B_W, point.separation, g.n_AB_W,
                     kSeparationBound);
    }
    expect(count == 0 || deepest == g.separation, "the deepest point has the pair's separation",
           all_digits(deepest) + " and " + all_digits(g.separation));
  }

  /// Just within max_separation the answer does not change, just beyond it is +inf and no point.
  void check_limits() {
    const Answer free = bench_.ask({0, 1}, {.kind = QueryKind::manifold});
    const double s = free.geometry.separation;
    if (!(s > kLeast)) return;
    const Answer within = bench_.ask({0, 1}, {.kind = QueryKind::distance, .max_separation = s});
    expect(within.geometry.separation == s, "separation at max_separation is given",
           all_digits(within.geometry.separation));
    const Answer beyond =
        bench_.ask({0, 1}, {.kind = QueryKind::manifold, .max_separation = std::nextafter(s, 0.0)});
    expect(beyond.status == PairStatus::separated && std::isinf(beyond.geometry.separation) &&
               beyond.geometry.point_count == 0,
           "beyond max_separation: separated, +inf, no points", all_digits(beyond.geometry.separation));
  }

  static std::string shown(const Vector3& v) {
    return "(" + all_digits(v.x()) + ", " + all_digits(v.y()) + ", " + all_digits(v.z()) + ")";
  }

  Bench bench_;
  WorldVertices a_W_, b_W_;
  double S_;
  bool same_;
  ExactResult exact_;
  CheckedPair out_;
};

}  // namespace

CheckedPair check_against_exact(const PosedSolids& solids, Narrowphase& narrowphase) {
  return Checker(solids, narrowphase).run();
}

}  // namespace touchstone::proof
