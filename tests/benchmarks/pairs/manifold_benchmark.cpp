#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "touchstone/contact_core/native/manifold/manifold.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/numerics/exact_predicates.hpp"

// make_manifold() alone on pairs prepared beforehand (contact, signed distance), and whole manifold queries
// through the interface. Each run walks 1024 pairs, so that no branch is learnt by heart; the figure is per
// pair. Argument: max_points.

namespace touchstone {
namespace {

constexpr std::size_t kPairs = 1024;

struct Crowd {
  std::vector<Hexahedron> solids;  // pair i: 2i and 2i + 1
  std::vector<Pose> poses;
};

class Draw {
 public:
  double uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_() >> 11) * 0x1p-53);
  }
  Vector3 vector(double reach) {
    return {uniform(-reach, reach), uniform(-reach, reach), uniform(-reach, reach)};
  }
  Matrix3 rotation() {
    for (;;) {
      const double w = uniform(-1, 1), x = uniform(-1, 1), y = uniform(-1, 1), z = uniform(-1, 1);
      const double square = w * w + x * x + y * y + z * z;
      if (square > 0.01 && square < 1.0) return rotation_from_quaternion(w, x, y, z);
    }
  }
  Hexahedron box() {
    return Hexahedron::from_size({uniform(0.5, 1.5), uniform(0.5, 1.5), uniform(0.5, 1.5)});
  }
  Hexahedron tapered() {
    const Vector3 half(uniform(0.25, 0.75), uniform(0.25, 0.75), uniform(0.25, 0.75));
    const double top = uniform(0.3, 1.0), lean = uniform(-0.2, 0.2);
    std::vector<Vector3> corners;
    for (int i = 0; i < 8; ++i) {
      const double m = i & 1 ? top : 1.0, up = i & 1 ? 1.0 : -1.0;
      corners.push_back(
          {(i & 4 ? m : -m) * half.x() + up * lean, (i & 2 ? m : -m) * half.y(), up * half.z()});
    }
    return Hexahedron::from_vertices(corners, WarpPolicy::accept);
  }
  Hexahedron warped() {
    for (;;) {
      std::vector<Vector3> corners;
      for (int i = 0; i < 8; ++i)
        corners.push_back(Vector3(i & 4 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 1 ? 0.5 : -0.5) + vector(0.06));
      try {
        return Hexahedron::from_vertices(corners, WarpPolicy::accept);
      } catch (const std::exception&) {
        // Not convex: draw again.
      }
    }
  }

 private:
  std::mt19937_64 engine_{1};
};

/// One on the other, turned about the common normal, 1/1000 deep; the whole tilted.
void add_resting(Draw& draw, const Hexahedron& below, const Hexahedron& above, Crowd& crowd) {
  const Matrix3 R = draw.rotation();
  const double angle = draw.uniform(-3.14, 3.14);
  Pose X_WA, X_WB;
  X_WA.R = R, X_WA.p = draw.vector(5);
  Matrix3 turn = Matrix3::Identity();
  turn(0, 0) = turn(1, 1) = std::cos(angle);
  turn(1, 0) = std::sin(angle), turn(0, 1) = -turn(1, 0);
  X_WB.R = R * turn;
  const double height = below.half_extents().z() + above.half_extents().z() - 1e-3;
  X_WB.p = X_WA.p + R * Vector3(draw.uniform(-0.3, 0.3), draw.uniform(-0.3, 0.3), height);
  crowd.solids.push_back(below), crowd.solids.push_back(above);
  crowd.poses.push_back(X_WA), crowd.poses.push_back(X_WB);
}

template <class Shape>
void add_overlapping(Draw& draw, const Shape& shape, Crowd& crowd) {
  for (;;) {
    const Hexahedron a = shape(), b = shape();
    Pose X_WA, X_WB;
    X_WA.R = draw.rotation(), X_WA.p = draw.vector(5);
    X_WB.R = draw.rotation(), X_WB.p = X_WA.p + draw.vector(1.2);
    WorldVertices a_W, b_W;
    world_vertices(a, X_WA, a_W), world_vertices(b, X_WB, b_W);
    if (!numerics::hulls_intersect(a_W, b_W)) continue;
    crowd.solids.push_back(a), crowd.solids.push_back(b);
    crowd.poses.push_back(X_WA), crowd.poses.push_back(X_WB);
    return;
  }
}

Crowd make_crowd(const std::string& family) {
  Draw draw;
  Crowd crowd;
  for (std::size_t i = 0; i < kPairs; ++i) {
    if (family == "resting_boxes")
      add_resting(draw, draw.box(), draw.box(), crowd);
    else if (family == "overlapping_boxes")
      add_overlapping(
          draw, [&] { return draw.box(); }, crowd);
    else if (family == "tapered")
      add_overlapping(
          draw, [&] { return draw.tapered(); }, crowd);
    else
      add_overlapping(
          draw, [&] { return draw.warped(); }, crowd);
  }
  return crowd;
}

struct Prepared {
  std::vector<native::SolidFeatures> features;
  std::vector<native::PosedPair> pairs;
  std::vector<native::SignedDistance> distances;
};

Prepared prepare(const Crowd& crowd) {
  Prepared out;
  for (const Hexahedron& solid : crowd.solids) out.features.push_back(native::find_features(solid));
  for (std::size_t i = 0; i < kPairs; ++i) {
    const std::size_t a = 2 * i, b = a + 1;
    native::PosedPair pair;
    WorldVertices a_W, b_W;
    world_vertices(crowd.solids[a], crowd.poses[a], a_W),
        world_vertices(crowd.solids[b], crowd.poses[b], b_W);
    native::shift_to_common_origin(a_W, b_W, pair.hulls);
    pair.a = &out.features[a], pair.b = &out.features[b];
    pair.R_WA = crowd.poses[a].R, pair.R_WB = crowd.poses[b].R;
    pair.start = pair.hulls.b.vertex(0) - pair.hulls.a.vertex(0);
    native::SignedDistance distance;
    native::penetration(pair, distance);
    out.pairs.push_back(pair), out.distances.push_back(distance);
  }
  return out;
}

void run_alone(benchmark::State& state, const std::string& family) {
  const Prepared prepared = prepare(make_crowd(family));
  const int max_points = static_cast<int>(state.range(0));
  native::Manifold manifold;
  double points = 0.0;
  for (auto _ : state) {
    points = 0.0;
    for (std::size_t i = 0; i < kPairs; ++i) {
      native::make_manifold(prepared.pairs[i], prepared.distances[i], INFINITY, max_points, false, manifold);
      benchmark::DoNotOptimize(manifold);
      points += manifold.count;
    }
  }
  state.counters["points"] = points / kPairs;
  state.counters["per_pair"] =
      benchmark::Counter(kPairs, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void run_query(benchmark::State& state, const std::string& family, QueryKind kind) {
  const Crowd crowd = make_crowd(family);
  const std::unique_ptr<Narrowphase> narrowphase = make_native();
  narrowphase->build(crowd.solids);
  const auto workspace = narrowphase->make_workspace();
  std::vector<SolidPair> pairs;
  for (SolidIndex i = 0; i < kPairs; ++i) pairs.push_back({2 * i, 2 * i + 1});
  std::vector<PairStatus> status(kPairs);
  std::vector<PairGeometry> geometry(kPairs);
  std::vector<ContactPoint> points(kPairs * kMaxManifoldPoints);
  const Query query{.kind = kind};
  for (auto _ : state) {
    narrowphase->evaluate({.pairs = pairs, .poses = crowd.poses, .query = query},
                          {.status = status, .geometry = geometry, .points = points}, *workspace);
    benchmark::DoNotOptimize(points.data());
  }
  state.counters["per_pair"] =
      benchmark::Counter(kPairs, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void register_runs() {
  for (const char* family : {"resting_boxes", "overlapping_boxes", "tapered", "warped"}) {
    const std::string name = family;
    benchmark::RegisterBenchmark(("make_manifold/" + name).c_str(),
                                 [name](benchmark::State& state) { run_alone(state, name); })
        ->Arg(8)
        ->Arg(4);
    benchmark::RegisterBenchmark(("query_manifold/" + name).c_str(), [name](benchmark::State& state) {
      run_query(state, name, QueryKind::manifold);
    });
    benchmark::RegisterBenchmark(("query_distance/" + name).c_str(), [name](benchmark::State& state) {
      run_query(state, name, QueryKind::distance);
    });
  }
}

}  // namespace
}  // namespace touchstone

int main(int argc, char** argv) {
  touchstone::register_runs();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
}
