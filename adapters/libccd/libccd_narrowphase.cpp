#include "touchstone/adapters/libccd/libccd_narrowphase.hpp"

#include <ccd/ccd.h>
#include <cassert>

#include <cmath>
#include <utility>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/narrowphase/no_geometry.hpp"
#include "touchstone/contact_core/narrowphase/validate.hpp"

namespace touchstone::libccd {
namespace {

static_assert(sizeof(ccd_real_t) == sizeof(double));

/// A solid as libccd's support function sees it.
struct Body {
  WorldVertices vertices;
  mutable unsigned long supports = 0;  ///< asked for in this query
};

void support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* out) {
  const Body& body = *static_cast<const Body*>(object);
  ++body.supports;
  const WorldVertices& v = body.vertices;
  const double* const d = direction->v;
  int best = 0;
  double highest = -kInfinity;
  for (int i = 0; i < Hexahedron::kVertices; ++i) {
    const double height = (d[0] * v.x[i] + d[1] * v.y[i]) + d[2] * v.z[i];
    if (height > highest) highest = height, best = i;
  }
  ccdVec3Set(out, v.x[best], v.y[best], v.z[best]);
}

void centre(const void* object, ccd_vec3_t* out) {
  const WorldVertices& v = static_cast<const Body*>(object)->vertices;
  Vector3 sum = Vector3::Zero();
  for (int i = 0; i < Hexahedron::kVertices; ++i) sum += v.vertex(i);
  ccdVec3Set(out, sum.x() / 8.0, sum.y() / 8.0, sum.z() / 8.0);
}

/// Products of four coordinates are taken; beyond this, and for what is not finite, no answer is trusted.
constexpr double kLargestCoordinate = 1e75;

bool is_in_range(const Body& body) {
  const WorldVertices& v = body.vertices;
  bool in_range = true;
  for (int i = 0; i < Hexahedron::kVertices; ++i)
    for (const double coordinate : {v.x[i], v.y[i], v.z[i]})
      in_range = in_range && std::abs(coordinate) <= kLargestCoordinate;
  return in_range;
}

ccd_t make_settings(unsigned long iterations) {
  ccd_t settings;
  CCD_INIT(&settings);
  settings.support1 = settings.support2 = &support;
  settings.center1 = settings.center2 = &centre;
  settings.max_iterations = iterations;
  return settings;
}

struct Depth {
  int code;  ///< 0: overlapping, -1: apart
  double depth;
  Vector3 n_AB_W;
  Vector3 p_W;
};

class Solver {
 public:
  Solver(Method method, unsigned long iterations) : method_(method), settings_(make_settings(iterations)) {}

  bool overlap(const Body& a, const Body& b) const {
    const auto check = method_ == Method::gjk ? &ccdGJKIntersect : &ccdMPRIntersect;
    return check(&a, &b, &settings_) != 0;
  }
  /// By MPR.
  Depth depth(const Body& a, const Body& b) const {
    double depth = kNaN;
    ccd_vec3_t n, p;
    ccdVec3Set(&n, kNaN, kNaN, kNaN);
    ccdVec3Set(&p, kNaN, kNaN, kNaN);
    const int code = ccdMPRPenetration(&a, &b, &settings_, &depth, &n, &p);
    return {code, depth, {n.v[0], n.v[1], n.v[2]}, {p.v[0], p.v[1], p.v[2]}};
  }

 private:
  Method method_;
  ccd_t settings_;
};

struct LibccdWorkspace final : Narrowphase::Workspace {
  Body a, b;
};

class LibccdNarrowphase final : public Narrowphase {
 public:
  LibccdNarrowphase(Method method, unsigned long iterations)
      : method_(method), iterations_(iterations), solver_(method, iterations) {
    capabilities_.penetration = method == Method::mpr;
    capabilities_.overlap_complete = false;  // pairs that just touch are missed
    const double tolerance = make_settings(iterations).mpr_tolerance;
    capabilities_.resolution = {tolerance, tolerance, kInfinity};
  }

  std::string_view name() const noexcept override {
    return method_ == Method::gjk ? "libccd_gjk" : "libccd_mpr";
  }
  const Capabilities& capabilities() const noexcept override { return capabilities_; }
  void build(std::span<const Hexahedron> solids) override {
    refuse_rounded(solids, "libccd");
    std::vector<Hexahedron> copy(solids.begin(), solids.end());
    solids_ = std::move(copy);
  }
  std::unique_ptr<Workspace> make_workspace() const override { return std::make_unique<LibccdWorkspace>(); }

  void evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                Workspace& workspace) const noexcept override {
    assert(fits(input, output, solids_.size()));
    auto& [a, b] = static_cast<LibccdWorkspace&>(workspace);
    for (std::size_t i = 0; i < input.pairs.size(); ++i) {
      const auto [index_a, index_b] = input.pairs[i];
      world_vertices(solids_[index_a], input.poses[index_a], a.vertices);
      world_vertices(solids_[index_b], input.poses[index_b], b.vertices);
      a.supports = b.supports = 0;
      PairGeometry unused;
      PairGeometry& geometry = output.geometry.empty() ? unused : output.geometry[i];
      geometry = no_geometry();
      output.status[i] =
          is_in_range(a) && is_in_range(b) ? answer(a, b, input.query, geometry) : PairStatus::failed;
    }
  }

 private:
  PairStatus answer(const Body& a, const Body& b, const Query& query, PairGeometry& geometry) const {
    if (query.kind == QueryKind::overlap) return overlap(a, b);
    if (query.kind == QueryKind::manifold || method_ == Method::gjk) return PairStatus::unsupported;
    return depth(a, b, query.max_separation > 0.0, geometry);
  }

  /// One support of each body comes before the first iteration, then one with each.
  bool at_limit(const Body& a) const { return a.supports > iterations_; }

  PairStatus overlap(const Body& a, const Body& b) const {
    if (solver_.overlap(a, b)) return PairStatus::overlapping;
    return at_limit(a) ? PairStatus::undecided : PairStatus::separated;
  }

  PairStatus depth(const Body& a, const Body& b, bool nearness_asked, PairGeometry& geometry) const {
    const Depth found = solver_.depth(a, b);
    if (found.code == -1) {
      if (nearness_asked) return PairStatus::unsupported;
      geometry = no_geometry(kInfinity);
      return PairStatus::separated;
    }
    const bool usable = found.code == 0 && !at_limit(a) && std::isfinite(found.depth) &&
                        is_finite(found.p_W) && norm(found.n_AB_W) > 0.5;  // a unit vector, or zero
    if (!usable) return PairStatus::failed;
    const Vector3 half = 0.5 * found.depth * found.n_AB_W;
    geometry = {-found.depth, found.n_AB_W, found.p_W + half, found.p_W - half, 0};
    return PairStatus::overlapping;
  }

  Method method_;
  unsigned long iterations_;
  Solver solver_;
  Capabilities capabilities_;
  std::vector<Hexahedron> solids_;
};

class LibccdRawCheck final : public RawCheck {
 public:
  explicit LibccdRawCheck(Method method) : solver_(method, kIterations) {}

  void build(std::span<const Hexahedron> solids) override {
    refuse_rounded(solids, "libccd");
    std::vector<Hexahedron> copy(solids.begin(), solids.end());
    solids_ = std::move(copy);
    bodies_.resize(solids_.size());
  }
  bool supports(QueryKind kind) const noexcept override { return kind == QueryKind::overlap; }
  void set_poses(std::span<const Pose> poses) override {
    for (std::size_t i = 0; i < solids_.size(); ++i)
      world_vertices(solids_[i], poses[i], bodies_[i].vertices);
  }
  std::size_t run(std::span<const SolidPair> pairs, QueryKind) noexcept override {
    std::size_t in_contact = 0;
    for (const auto [a, b] : pairs) in_contact += solver_.overlap(bodies_[a], bodies_[b]) ? 1 : 0;
    return in_contact;
  }

 private:
  Solver solver_;
  std::vector<Hexahedron> solids_;
  std::vector<Body> bodies_;
};

}  // namespace

std::unique_ptr<Narrowphase> make_narrowphase(Method method, unsigned long iterations) {
  return std::make_unique<LibccdNarrowphase>(method, iterations);
}
std::unique_ptr<RawCheck> make_raw_check(Method method) { return std::make_unique<LibccdRawCheck>(method); }

}  // namespace touchstone::libccd
