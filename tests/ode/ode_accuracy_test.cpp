#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <iostream>

#include "tests/ode/ode_scenes.hpp"

// What ODE 0.16.2 as packaged by Debian 12 gets wrong, measured against a plain separating-axis reference.

namespace touchstone::ode_test {
namespace {

struct Figures {
  int apart = 0, together = 0, missed = 0, phantom = 0, failed = 0, kinds_disagree = 0;
  double worst_missed = 0.0, worst_phantom = 0.0, worst_depth_error = 0.0, median_depth_error = 0.0,
         least_error = 0.0;
};

Figures measure(const char* what, bool shear, const Vector3& centre) {
  const PairScene scene = random_pairs(20000, shear, centre, 11);
  const auto narrowphase = registry().make_narrowphase("ode");
  narrowphase->build(scene.solids);
  const Answers overlap = ask(*narrowphase, scene.pairs, scene.poses, Query{});
  const Answers distance = ask(*narrowphase, scene.pairs, scene.poses, Query{.kind = QueryKind::distance});
  Figures figures;
  std::vector<double> errors;
  for (std::size_t i = 0; i < scene.pairs.size(); ++i) {
    const double depth = reference_depth(scene.solids[2 * i], scene.poses[2 * i], scene.solids[2 * i + 1],
                                         scene.poses[2 * i + 1]);
    const bool seen = overlap.status[i] == PairStatus::overlapping;
    (depth >= 0 ? figures.together : figures.apart) += 1;
    if (depth >= 0 && !seen)
      figures.missed += 1, figures.worst_missed = std::max(figures.worst_missed, depth);
    if (depth < 0 && seen)
      figures.phantom += 1, figures.worst_phantom = std::max(figures.worst_phantom, -depth);
    figures.failed += distance.status[i] == PairStatus::failed;
    figures.kinds_disagree += seen != (distance.status[i] == PairStatus::overlapping);
    if (depth < 0 || distance.status[i] != PairStatus::overlapping) continue;
    const double error = -distance.geometry[i].separation - depth;
    figures.least_error = std::min(figures.least_error, error);
    errors.push_back(std::abs(error));
  }
  std::sort(errors.begin(), errors.end());
  figures.worst_depth_error = errors.back();
  figures.median_depth_error = errors[errors.size() / 2];
  std::cout << what << ": together " << figures.together << " apart " << figures.apart << " missed "
            << figures.missed << " (deepest " << figures.worst_missed << " m) phantom " << figures.phantom
            << " (furthest " << figures.worst_phantom << " m) failed " << figures.failed << " kinds disagree "
            << figures.kinds_disagree << " depth error median " << figures.median_depth_error << " p99 "
            << errors[errors.size() * 99 / 100] << " worst " << figures.worst_depth_error << " least "
            << figures.least_error << "\n";
  return figures;
}

TEST(OdeAccuracy, Boxes) { measure("boxes", false, Vector3::Zero()); }
TEST(OdeAccuracy, BoxesAMegametreOut) { measure("boxes at 1e6", false, {1e6, -1e6, 1e6}); }
TEST(OdeAccuracy, Sheared) { measure("sheared", true, Vector3::Zero()); }
TEST(OdeAccuracy, ShearedAMegametreOut) { measure("sheared at 1e6", true, {1e6, -1e6, 1e6}); }

TEST(OdeAccuracy, RawTimes) {
  for (const bool shear : {false, true}) {
    const PairScene scene = random_pairs(2000, shear, Vector3::Zero(), 12);
    const auto raw = registry().narrowphase("ode").make_raw();
    raw->build(scene.solids);
    raw->set_poses(scene.poses);
    for (const QueryKind kind : {QueryKind::overlap, QueryKind::manifold}) {
      double best = 1e300;
      std::size_t in_contact = 0;
      for (int i = 0; i < 20; ++i) {
        const auto start = std::chrono::steady_clock::now();
        in_contact = raw->run(scene.pairs, kind);
        best = std::min(
            best, std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count());
      }
      std::cout << (shear ? "sheared " : "boxes ") << to_string(kind) << ' ' << best / 2000 << " ns\n";
      EXPECT_GT(in_contact, 0u);
      EXPECT_LT(in_contact, scene.pairs.size());
    }
  }
}

}  // namespace
}  // namespace touchstone::ode_test
