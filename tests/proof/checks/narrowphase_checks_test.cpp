#include "touchstone/tests/proof/checks/narrowphase_checks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "touchstone/examples/measures/common/random.hpp"
#include "touchstone/tests/proof/checks/lying_narrowphase.hpp"
#include "touchstone/tests/proof/pairs/byte_decoder.hpp"
#include "touchstone/tests/proof/pairs/families.hpp"
#include "touchstone/tests/proof/pairs/pair_text.hpp"

// The fuzzer's checks: on the bytes kept in corpus/, on random bytes, and on answers that are known to be
// wrong.

namespace touchstone::proof {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes random_bytes(std::uint64_t seed) {
  measures::Random random(seed);
  Bytes bytes(kDecodedBytes);
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random.next() >> 56);
  return bytes;
}

Bytes read_bytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::string first_failure(const PosedSolids& solids, Narrowphase& narrowphase) {
  const CheckedPair checked = check_against_exact(solids, narrowphase);
  return checked.failures.empty() ? "" : checked.failures[0];
}

TEST(NativeKeepsItsPromises, OnTheCorpus) {
  int pairs = 0;
  for (const auto& file : std::filesystem::directory_iterator(TOUCHSTONE_FUZZ_CORPUS)) {
    const auto solids = decode_pair(read_bytes(file));
    if (!solids) continue;
    ++pairs;
    EXPECT_EQ(first_failure(*solids, *make_native()), "") << file.path() << "\n" << pair_text(*solids);
  }
  EXPECT_GE(pairs, 50);
}

TEST(NativeKeepsItsPromises, OnRandomBytes) {
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const auto solids = decode_pair(random_bytes(seed));
    if (!solids) continue;
    EXPECT_EQ(first_failure(*solids, *make_native()), "") << "seed " << seed << "\n" << pair_text(*solids);
  }
}

// ---- what the fuzzer found, each under the name of what it broke

void expect_all_kept(const PosedSolids& solids) {
  EXPECT_EQ(first_failure(solids, *make_native()), "") << pair_text(solids);
}

void expect_all_kept(const std::string& found) {
  expect_all_kept(*decode_pair(read_bytes(TOUCHSTONE_FOUND_PAIRS "/" + found)));
}

/// A sheet 2^-59 thick at x = 4, where its two layers fall together. Opposite corners are drawn out by
/// `drawn`, of one layer the first pair and of the other the second: the world hull's edges join corners of
/// different layers and are diagonals of the side faces. A bar along x, turned by 45 degrees about it, is
/// sunk edge on into such an edge by 1/16.
PosedSolids bar_on_twisted_sheet(double drawn) {
  std::array<Vector3, 8> v;
  for (int i = 0; i < 8; ++i) {
    const Vector3 corner(i & 4 ? 0x1p-60 : -0x1p-60, i & 2 ? 1.0 : -1.0, i & 1 ? 1.0 : -1.0);
    const bool is_drawn = (corner.y() * corner.z() > 0) == (corner.x() < 0);
    v[i] = is_drawn ? Vector3(corner.x(), corner.y() * (1.0 + drawn), corner.z() * (1.0 + drawn)) : corner;
  }
  PosedSolids solids{Hexahedron::from_vertices(v, WarpPolicy::accept), Hexahedron::from_size({4, 1, 1}),
                     Pose{}, Pose{}};
  const double c = std::sqrt(0.5);
  solids.X_WB.R << 1, 0, 0, 0, c, -c, 0, c, c;
  solids.X_WA.p.x() = solids.X_WB.p.x() = 4.0;
  solids.X_WB.p.y() = 1.0 + drawn + c - 0.0625;
  return solids;
}

TEST(FoundPair, TwistedSheet) {
  for (const int drawn : {-3, -10, -20, -30, -40, -49})
    expect_all_kept(bar_on_twisted_sheet(std::ldexp(1.0, drawn)));
}

TEST(FoundPair, SliverOfTheDecoder) { expect_all_kept(*decode_pair(random_bytes(319))); }

TEST(FoundPair, ManifoldPointOffItsRelation) { expect_all_kept("manifold_point_off_its_relation"); }

TEST(FoundPair, SeparationAtMaxSeparationWithheld) {
  expect_all_kept("separation_at_max_separation_withheld");
}

TEST(FoundPair, LostDistanceBesideItsManifold) { expect_all_kept("lost_distance_beside_its_manifold"); }

/// A box within a frustum, flush with its base, of 2^198: a vertex of the base once counted as over the box.
TEST(FoundPair, WitnessOfAScaledPair) {
  const auto solids = decode_pair(read_bytes(TOUCHSTONE_FOUND_PAIRS "/witness_of_a_scaled_pair"));
  const CheckedPair checked = check_against_exact(*solids, *make_native());
  EXPECT_TRUE(checked.failures.empty());
  EXPECT_LE(checked.witness_error, kSeparationBound);
}

PosedSolids sharp_rim_pair() {
  const std::array<Vector3, 8> a = {{{-0.4956693274765714, -0.2836688889391089, -1.2011545677372817},
                                     {-0.4956693274765714, -0.20929450020540205, 0.8862270581176543},
                                     {-0.4956693274765714, 0.20929450020540205, -0.8862270581176543},
                                     {-0.4956693274765714, 0.2836688889391089, 1.2011545677372817},
                                     {0.4956693274765714, -0.20929450020540205, -0.8862270581176543},
                                     {0.4956693274765714, -0.2836688889391089, 1.2011545677372817},
                                     {0.4956693274765714, 0.2836688889391089, -1.2011545677372817},
                                     {0.4956693274765714, 0.20929450020540205, 0.8862270581176543}}};
  const std::array<Vector3, 8> b = {{{-0.6158935509212617, -3.4775715776103346e-16, 0.5919800704901328},
                                     {0.30361009514764037, 1.4708415017759556e-15, 0.8665890128198392},
                                     {0.8931253909489203, 2.7522857491992608e-15, -0.7615252684957965},
                                     {0.17037753187111848, 6.687410029769387e-17, -0.9790772027192802},
                                     {0.4917767484505624, -1.5907049264353187e-15, 0.9522457582594159},
                                     {0.37486802314218437, -1.2737616735562251e-15, 0.5747023383996803},
                                     {0.03583723424695062, 8.994374850452145e-16, 0.5178452027050642},
                                     {-0.17619926746826597, -3.7375552789302677e-16, 0.36091849540219934}}};
  PosedSolids solids{Hexahedron::from_vertices(a, WarpPolicy::accept),
                     Hexahedron::from_vertices(b, WarpPolicy::accept), Pose{}, Pose{}};
  solids.X_WA.R << 1, 4.0050155361455787e-16, 3.262800398555498e-16, -4.005015536145577e-16, 1,
      -5.569479234413542e-16, -3.2628003985555e-16, 5.56947923441354e-16, 1;
  solids.X_WA.p = {0.2601641556296388, 0.39311900133423494, -0.7269644758353093};
  solids.X_WB.p = {0.27972133852846603, 0.4643360637338789, -0.7309557078018564};
  return solids;
}

/// A sheet 2^-50 thick in a block: points beyond its rim are within rounding of all its planes.
TEST(FoundPair, WitnessBeyondASharpRim) {
  const auto solids = sharp_rim_pair();
  const CheckedPair checked = check_against_exact(solids, *make_native());
  EXPECT_TRUE(checked.failures.empty());
  EXPECT_LE(checked.witness_error, kSeparationBound);
}

TEST(NativeKeepsItsPromises, OnSlivers) {
  std::size_t family = 0;
  while (families()[family].name != "slivers") ++family;
  for (std::uint64_t index = 0; index < 500; ++index) {
    const PosedSolids solids = make_pair(family, 1, index);
    EXPECT_EQ(first_failure(solids, *make_native()), "") << index << "\n" << pair_text(solids);
  }
}

TEST(ByteDecoder, GivesAllKindsOfPairs) {
  int decoded = 0, boxes = 0, warped = 0, overlapping = 0, tiny = 0, turned = 0;
  const auto native = make_native();
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    // Kinds of solids that random bytes make.
    const auto solids = decode_pair(random_bytes(seed));
    if (!solids) continue;
    ++decoded;
    boxes += solids->a.is_box() && solids->b.is_box();
    warped += solids->a.is_warped();
    tiny += solids->a.size() < 1e-30;
    turned += solids->X_WB.R != Matrix3::Identity();
    // How many of them overlap.
    native->build(std::array{solids->a, solids->b});
    PairStatus status{};
    const std::array pairs = {SolidPair{0, 1}};
    const std::array poses = {solids->X_WA, solids->X_WB};
    native->evaluate({.pairs = pairs, .poses = poses, .query = {}}, {.status = {&status, 1}},
                     *native->make_workspace());
    overlapping += status == PairStatus::overlapping;
  }
  // No kind is rare.
  EXPECT_GT(decoded, 1000);
  EXPECT_GT(boxes, 100);
  EXPECT_GT(warped, 50);
  EXPECT_GT(tiny, 50);
  EXPECT_GT(turned, 500);
  EXPECT_GT(overlapping, 200);
  EXPECT_GT(decoded - overlapping, 200);
}

TEST(ByteDecoder, TakesAnyBytes) {
  EXPECT_TRUE(decode_pair({}));
  for (int byte = 0; byte < 256; ++byte) {
    const Bytes bytes(300, static_cast<std::uint8_t>(byte));
    for (const std::size_t size : {1u, 7u, 40u, 300u}) decode_pair(std::span(bytes).first(size));
  }
}

// ---- what the checks must catch

PosedSolids known_pair() {
  PosedSolids solids{Hexahedron::from_size({1, 2, 1}), Hexahedron::from_size({1, 1, 1}), Pose{}, Pose{}};
  solids.X_WB.R = rotation_from_quaternion(0.8, 0.2, -0.4, 0.3);
  solids.X_WB.p = {1.75, 0.25, 0.5};
  return solids;
}

bool says(const NarrowphaseInput& input, QueryKind kind) { return input.query.kind == kind; }

std::string caught(const LyingNarrowphase::Lie& lie) {
  LyingNarrowphase lying(lie);
  return first_failure(known_pair(), lying);
}

TEST(Checks, PassTheKnownPair) {
  EXPECT_EQ(caught([](const auto&, const auto&) {}), "");
}

TEST(Checks, CatchAWrongStatusInEachQuery) {
  for (const QueryKind kind : {QueryKind::overlap, QueryKind::distance, QueryKind::manifold}) {
    const std::string found = caught([kind](const auto& input, const auto& output) {
      if (says(input, kind))
        for (PairStatus& status : output.status) status = PairStatus::overlapping;
    });
    EXPECT_EQ(found.rfind(std::string(to_string(kind)) + " query: status separated", 0), 0u) << found;
  }
}

TEST(Checks, CatchADistanceJustBeyondItsBound) {
  const auto shifted = [](double by) {
    return [by](const NarrowphaseInput& input, const NarrowphaseOutput& output) {
      if (says(input, QueryKind::overlap)) return;
      for (PairGeometry& g : output.geometry) g.separation += by, g.p_B_W += by * g.n_AB_W;
    };
  };
  // S of the known pair is the largest coordinate, between 2 and 3.
  EXPECT_EQ(caught(shifted(5e-15)).find("separation within"), std::string::npos);
  EXPECT_NE(caught(shifted(4e-14)).find("separation within"), std::string::npos);
}

TEST(Checks, CatchATurnedNormalAndAWitnessOffTheRelation) {
  const std::string normal = caught([](const auto&, const auto& output) {
    for (PairGeometry& g : output.geometry) g.n_AB_W = -g.n_AB_W;
  });
  EXPECT_NE(normal, "");
  const std::string witness = caught([](const auto&, const auto& output) {
    for (PairGeometry& g : output.geometry) g.p_B_W.x() += 1e-14;
  });
  EXPECT_NE(witness.find("witness points"), std::string::npos) << witness;
}

TEST(Checks, CatchAnAnswerThatDependsOnTheOrderOrTheBatch) {
  const std::string order = caught([](const auto& input, const auto& output) {
    for (std::size_t i = 0; i < output.geometry.size(); ++i)
      if (input.pairs[i].a == 5)
        output.geometry[i].separation = std::nextafter(output.geometry[i].separation, 9.0);
  });
  EXPECT_NE(order.find("(b,a) has the separation"), std::string::npos) << order;
  const std::string batch = caught([](const auto& input, const auto& output) {
    if (input.pairs.size() > 1 && !output.geometry.empty())
      output.geometry[18].p_A_W.z() = std::nextafter(output.geometry[18].p_A_W.z(), 9.0);
  });
  EXPECT_NE(batch.find("a batch gives the bits"), std::string::npos) << batch;
  const std::string cache = caught([](const auto& input, const auto& output) {
    if (!input.cache.empty()) output.status[3] = PairStatus::overlapping;
  });
  EXPECT_NE(cache.find("a batch gives the bits"), std::string::npos) << cache;
}

TEST(Checks, CatchAManifoldWithoutItsDeepestPointAndABoundAsADistance) {
  const std::string deepest = caught([](const auto& input, const auto& output) {
    if (says(input, QueryKind::manifold))
      for (ContactPoint& point : output.points) point.separation += 1e-3;
  });
  EXPECT_NE(deepest, "");
  const std::string bound = caught([](const auto& input, const auto& output) {
    for (PairGeometry& g : output.geometry)
      if (std::isinf(g.separation)) g.separation = input.query.max_separation;
  });
  EXPECT_NE(bound.find("beyond max_separation"), std::string::npos) << bound;
}

}  // namespace
}  // namespace touchstone::proof
