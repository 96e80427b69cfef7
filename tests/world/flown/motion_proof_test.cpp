#include "touchstone/tests/world/flown/motion_proof.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>

#include "touchstone/adapters/all/all_backends.hpp"

namespace touchstone {
namespace {

std::vector<std::string> known(const std::vector<std::string>& wanted) {
  const std::vector<std::string> all = all_backend_names();
  std::vector<std::string> out;
  for (const std::string& name : wanted)
    if (std::find(all.begin(), all.end(), name) != all.end()) out.push_back(name);
  return out;
}

// A slice of what `motion_proof` runs whole. Seed 10 holds six poses that merged, by up to 7 mm, when the
// bound on the height of two edges in contact could curve upwards (edge_stretch() in
// motion/clear_stretch.cpp).
TEST(MotionProof, NothingExecutedOverlapsOrDeepensAndOrderDoesNotShow) {
  std::vector<MotionFigures> figures;
  for (const std::string& name : known({"native", "exact"})) {
    figures.push_back(prove_motions({name, "native", name == "native" ? 3000u : 500u, 10}));
    const MotionFigures& f = figures.back();
    EXPECT_FALSE(f.is_sampled);
    EXPECT_EQ(f.actual_overlaps, 0u) << name;
    EXPECT_EQ(f.path_overlaps, 0u) << name;
    EXPECT_EQ(f.deepened, 0u) << name << " by " << f.deepest_growth;
    EXPECT_EQ(f.order_shows, 0u) << name;
    EXPECT_GT(f.blocked, f.motions / 10);
  }
  EXPECT_GT(figures.front().overlapping_starts, 0u);
  print_table(std::cout, figures);
}

TEST(MotionProof, RoundedSolidsDoNotMergeEither) {
  std::vector<MotionFigures> figures;
  for (const std::string& name : known({"native", "exact"})) {
    figures.push_back(prove_motions({name, "native", name == "native" ? 3000u : 300u, 11, true}));
    const MotionFigures& f = figures.back();
    EXPECT_EQ(f.violations(), 0u) << name;
    EXPECT_GT(f.blocked, f.motions / 10);
    EXPECT_GT(f.slid_frames, 0u);
  }
  print_table(std::cout, figures);
}

// Others are counted; sampled motion is reported as such.
TEST(MotionProof, OtherBackendsAreCounted) {
  std::vector<MotionFigures> figures;
  for (const std::string& name : known({"bullet_gjk", "bullet", "ode", "edge_face"})) {
    figures.push_back(prove_motions({name, "native", 600, 7}));
    EXPECT_EQ(figures.back().is_sampled, name != "bullet_gjk") << name;
    EXPECT_GT(figures.back().blocked, 0u) << name;
  }
  print_table(std::cout, figures);
}

// Any broadphase in its place: the same poses, so the same figures.
TEST(MotionProof, BroadphaseDoesNotShow) {
  const MotionFigures native = prove_motions({"native", "native", 600, 9});
  const MotionFigures rounded = prove_motions({"native", "native", 600, 9, true});
  for (const char* name : {"brute_force", "bullet", "ode"}) {
    BackendRegistry registry;
    register_all_backends(registry);
    bool has = false;
    for (const BackendRegistry::BroadphaseEntry& entry : registry.broadphases()) has |= entry.name == name;
    if (!has) continue;
    const MotionFigures other = prove_motions({"native", name, 600, 9});
    EXPECT_EQ(other.blocked, native.blocked) << name;
    EXPECT_EQ(other.slid_frames, native.slid_frames) << name;
    EXPECT_EQ(other.violations(), 0u) << name;
    const MotionFigures round = prove_motions({"native", name, 600, 9, true});
    EXPECT_EQ(round.blocked, rounded.blocked) << name;
    EXPECT_EQ(round.slid_frames, rounded.slid_frames) << name;
    EXPECT_EQ(round.violations(), 0u) << name;
  }
}

}  // namespace
}  // namespace touchstone
