// Times of impact: find_impact() over native beside Bullet's sweeps and FCL's continuous collision on the
// same motions; what each misses, and how early or late it is, by `exact`.
//
//     impact_benchmark [motions of each family, default 1000] [seed, default 1]
//
// Truth: from s on, the pair stays apart for exact's distance over a bound on the relative speed; never less
// than 1 mm of way is gone at a time, half of the thinnest plate. Before what it finds nothing touches, but
// for what grazes within that.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/adapters/exact/exact.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/motion/impact.hpp"
#include "touchstone/contact_core/motion/narrowphase_query.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/tests/benchmarks/motion/fcl_check.hpp"
#include "touchstone/tests/benchmarks/motion/impact_motions.hpp"

namespace touchstone::impact {
namespace {

using Clock = std::chrono::steady_clock;
constexpr double kGap = 1e-7;
constexpr double kLeastWay = 1e-3;     // [m]
constexpr double kSameTime = 0x1p-40;  // of the motion: rounding

double radius(const Hexahedron& solid) {
  double r = 0.0;
  for (const Vector3& vertex : solid.vertices()) r = std::max(r, norm(vertex));
  return r;
}

/// No point of one moves faster past the other's [m per unit of s].
double speed_bound(const Motion& motion) {
  const BodyState a = motion.path_a.at(0, 0.0), b = motion.path_b.at(0, 0.0);
  return norm(a.velocity_W - b.velocity_W) + norm(a.angular_velocity_W) * radius(motion.a) +
         norm(b.angular_velocity_W) * radius(motion.b);
}

MovingSolid moving(const Hexahedron& solid, const RigidPath& path) {
  const BodyState state = path.at(0, 0.0);
  return {&solid, {}, &path, 0, 1.0, norm(state.velocity_W) + norm(state.angular_velocity_W) * radius(solid)};
}

class Ours final : public Sweep {
 public:
  void set(const Hexahedron& a, const RigidPath& path_a, const Hexahedron& b,
           const RigidPath& path_b) override {
    const std::vector<Hexahedron> solids{a, b};
    native_->build(solids);
    query_.emplace(*native_, 2);
    a_ = moving(a, path_a), b_ = moving(b, path_b);
  }
  std::optional<double> impact() override {
    const Impact found = find_impact(a_, b_, {kGap}, *query_, 0.0, 1.0, false);
    return found.status == ImpactStatus::clear ? std::nullopt : std::optional(found.lo);
  }

 private:
  std::unique_ptr<Narrowphase> native_ = make_native();
  std::optional<NarrowphaseQuery> query_;
  MovingSolid a_{}, b_{};
};

/// A measurement, named as its row is.
struct Method {
  std::string name;
  std::unique_ptr<Sweep> sweep;
};

/// `exact` on one motion.
class Judge {
 public:
  Judge() {
    BackendRegistry registry;
    register_exact(registry);
    exact_ = registry.make_narrowphase("exact");
  }
  void set(const Motion& motion) {
    motion_ = &motion;
    const std::vector<Hexahedron> solids{motion.a, motion.b};
    exact_->build(solids);
    query_.emplace(*exact_, 2);
  }
  double separation(double s) {
    PairGeometry geometry{};
    query_->separation(motion_->path_a.pose_at(s), motion_->path_b.pose_at(s), geometry);
    return geometry.separation;
  }
  /// The first s at which they touch; above 1: they do not.
  double first_touch() {
    const double speed = speed_bound(*motion_);
    double clear = 0.0;
    for (double s = 0.0; s <= 1.0;) {
      const double d = separation(s);
      if (d <= 0.0) return bisect(clear, s);
      clear = s;
      if (s == 1.0) break;
      s = std::min(1.0, s + std::max(kLeastWay, d) / speed);
    }
    return 2.0;
  }

 private:
  double bisect(double clear, double touching) {
    for (int i = 0; i < 60 && touching - clear > 0x1p-52; ++i) {
      const double middle = 0.5 * (clear + touching);
      (separation(middle) <= 0.0 ? touching : clear) = middle;
    }
    return touching;
  }

  const Motion* motion_ = nullptr;
  std::unique_ptr<Narrowphase> exact_;
  std::optional<NarrowphaseQuery> query_;
};

struct Score {
  std::vector<double> ns, off;  // off: |separation| where they meet by the answer [m], of true meetings
  int missed = 0, phantom = 0, late = 0, merged = 0;
  double deepest = 0.0, earliest = 0.0;
};

double quantile(std::vector<double>& values, double share) {
  if (values.empty()) return kNaN;
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1,
                         static_cast<std::size_t>(share * static_cast<double>(values.size())))];
}

/// The least of three calls: what else the machine does is not the method's.
std::optional<double> timed(Sweep& sweep, Score& score) {
  std::optional<double> said;
  double least = kInfinity;
  for (int i = 0; i < 3; ++i) {
    const Clock::time_point start = Clock::now();
    said = sweep.impact();
    least = std::min(least, std::chrono::duration<double, std::nano>(Clock::now() - start).count());
  }
  score.ns.push_back(least);
  return said;
}

void look(const std::optional<double>& said, double truth, Judge& judge, Score& score) {
  const bool meets = truth <= 1.0;
  if (!said) {
    score.missed += meets ? 1 : 0;
    return;
  }
  const double separation = judge.separation(std::clamp(*said, 0.0, 1.0));
  if (!meets) ++score.phantom;
  if (meets) score.off.push_back(std::abs(separation));
  if (meets && *said > truth + kSameTime) ++score.late;
  if (meets && *said < truth) score.earliest = std::max(score.earliest, separation);
  if (separation <= 0.0) ++score.merged, score.deepest = std::max(score.deepest, -separation);
}

/// Says of how many motions a row is where that is not all.
std::string row_name(const Method& method, const Score& score, int count) {
  const auto asked = static_cast<int>(score.ns.size());
  return asked == count ? method.name : method.name + ", " + std::to_string(asked) + " of these";
}

void run(const Family& family, int count, std::uint64_t seed, std::vector<Method>& methods) {
  // The truth of each motion first; those that start in contact do not count.
  std::mt19937_64 random(seed);
  Judge judge;
  std::vector<Score> scores(methods.size());
  int meetings = 0;
  for (int i = 0; i < count;) {
    const Motion motion = family.make(random);
    judge.set(motion);
    if (judge.separation(0.0) <= 2.0 * kGap) continue;  // starts in contact
    ++i;
    const double truth = judge.first_touch();
    meetings += truth <= 1.0 ? 1 : 0;
    // Every method that takes turns as large.
    for (std::size_t m = 0; m < methods.size(); ++m) {
      Sweep& sweep = *methods[m].sweep;
      if (std::max(turn_of(motion.path_a), turn_of(motion.path_b)) > sweep.most_turn()) continue;
      sweep.set(motion.a, motion.path_a, motion.b, motion.path_b);
      look(timed(sweep, scores[m]), truth, judge, scores[m]);
    }
  }
  // A row for each method that took some motion of the family.
  std::printf("\n### %s: %d motions, %d meet\n\n", std::string(family.name).c_str(), count, meetings);
  std::printf(
      "| | median [ns] | 99.9 %% | worst | missed | phantom | late | shown merged | deepest [m] | off, "
      "median "
      "[m] | off, worst | early, worst |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (std::size_t m = 0; m < methods.size(); ++m) {
    Score& score = scores[m];
    if (score.ns.empty()) continue;
    std::printf("| %s | %.0f | %.0f | %.0f | %d | %d | %d | %d | %.2g | %.2g | %.2g | %.2g |\n",
                row_name(methods[m], score, count).c_str(), quantile(score.ns, 0.5),
                quantile(score.ns, 0.999), quantile(score.ns, 1.0), score.missed, score.phantom, score.late,
                score.merged, score.deepest, quantile(score.off, 0.5), quantile(score.off, 1.0),
                score.earliest);
  }
  std::fflush(stdout);
}

}  // namespace

std::vector<Method> all_methods() {
  std::vector<Method> methods;
  methods.push_back({"find_impact, native", std::make_unique<Ours>()});
  std::vector<SweepEntry> entries = all_sweeps();
#ifdef TOUCHSTONE_BENCHMARK_FCL
  entries.push_back(fcl_naive_1000());
#endif
  for (const SweepEntry& entry : entries) methods.push_back({entry.description, entry.make()});
  return methods;
}

}  // namespace touchstone::impact

int main(int argc, char** argv) {
  using namespace touchstone::impact;
  const int count = argc > 1 ? std::atoi(argv[1]) : 1000;
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  if (count <= 0) {
    std::fprintf(stderr, "impact_benchmark: the number of motions must be > 0\n");
    return 1;
  }
  std::vector<Method> methods = all_methods();
#ifdef TOUCHSTONE_BENCHMARK_FCL
  print_fcl_check();
#endif
  for (const Family& family : families()) run(family, count, seed, methods);
}
