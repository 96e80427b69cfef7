#include <gtest/gtest.h>

#include "native_fixture.hpp"
#include "touchstone/contact_core/native/overlap/overlap.hpp"
#include "touchstone/contact_core/native/simd/kernels.hpp"
#include "touchstone/contact_core/numerics/exact_predicates.hpp"

// The kernels of every instruction set that this machine has, against the exact answer and one another.

namespace touchstone {
namespace {

using native::Certified;

struct Crowd {
  std::vector<Hexahedron> solids;
  std::vector<Pose> poses;
  std::vector<SolidPair> pairs;
  std::vector<bool> meet;

  void add(const Hexahedron& a, const Pose& X_WA, const Hexahedron& b, const Pose& X_WB) {
    const auto first = static_cast<SolidIndex>(solids.size());
    solids.push_back(a), solids.push_back(b);
    poses.push_back(X_WA), poses.push_back(X_WB);
    pairs.push_back({first, first + 1});
    WorldVertices a_W, b_W;
    world_vertices(a, X_WA, a_W);
    world_vertices(b, X_WB, b_W);
    meet.push_back(numerics::hulls_intersect(a_W, b_W));
  }
};

/// Apart, overlapping, within an ulp of touching, far away; ordinary magnitudes and others; all kinds.
Crowd make_crowd(int count) {
  Random random(41);
  Crowd out;
  for (int i = 0; i < count; ++i) {
    const Hexahedron a = random.any(), b = random.any();
    Pose X_WA = random.pose(0.3), X_WB = random.pose(1.2);
    if (i % 3 == 1) {
      const PairGeometry g = ask(a, X_WA, b, X_WB, QueryKind::distance).geometry;
      X_WB.p -= g.separation * g.n_AB_W;
    } else if (i % 3 == 2) {
      const Vector3 far = random.vector(std::ldexp(1.0, random.below(40)));
      X_WA.p += far, X_WB.p += far;
    }
    out.add(a, X_WA, b, X_WB);
    if (i % 20 == 0) {
      for (const double k : {0x1p-400, 0x1p-125, 0x1p-110, 0x1p110, 0x1p125, 0x1p400}) {
        const Hexahedron cube = Hexahedron::from_size(Vector3::Constant(k));
        Pose X_k = random.pose(0.9);
        X_k.p *= k;
        out.add(cube, at(0, 0, 0), cube, X_k);
      }
    }
  }
  return out;
}

const native::PoseRecord* records(const Crowd& crowd) {
  return reinterpret_cast<const native::PoseRecord*>(crowd.poses.data());
}

TEST(NativeKernels, WhatThePortalCertifiesIsSoOnEveryInstructionSet) {
  const Crowd crowd = make_crowd(600);
  const native::SolidSet set = native::make_solid_set(crowd.solids);
  std::vector<native::PairIndices> pairs;
  for (const SolidPair& pair : crowd.pairs) pairs.push_back({pair.a, pair.b});
  const auto certify = [&](const native::Kernels& kernels, int steps) {
    std::vector<Certified> out(pairs.size());
    kernels.certify_by_mpr(records(crowd), set.vertices.data(), pairs.data(), pairs.size(), steps, out.data(),
                           nullptr);
    return out;
  };
  const native::KernelList& list = native::available_kernels();
  for (const int steps : {0, 1, 8}) {
    const std::vector<Certified> plain = certify(*list.of[0], steps);
    int known = 0;
    for (std::size_t i = 0; i < plain.size(); ++i) {
      if (plain[i] == Certified::unknown) continue;
      ++known;
      EXPECT_EQ(plain[i] == Certified::overlapping, crowd.meet[i]) << i;
    }
    EXPECT_GT(known, steps == 8 ? 300 : 50);
    for (int k = 1; k < list.count; ++k) EXPECT_EQ(certify(*list.of[k], steps), plain) << list.of[k]->isa;
  }
}

TEST(NativeKernels, BatchesAndSinglePairsAreRightOnEveryInstructionSet) {
  const Crowd crowd = make_crowd(600);
  const native::SolidSet set = native::make_solid_set(crowd.solids);
  std::vector<PairStatus> batch(crowd.pairs.size());
  const native::KernelList& list = native::available_kernels();
  for (int k = 0; k < list.count; ++k) {
    SCOPED_TRACE(list.of[k]->isa);
    // Sizes that leave lanes empty and blocks part full.
    for (const std::size_t size : {std::size_t{1}, std::size_t{3}, std::size_t{7}, batch.size()}) {
      for (std::size_t i = 0; i < batch.size(); i += size) {
        const std::size_t here = std::min(size, batch.size() - i);
        native::overlap(set, *list.of[k], std::span(crowd.pairs).subspan(i, here), crowd.poses,
                        std::span(batch).subspan(i, here));
      }
      for (std::size_t i = 0; i < batch.size(); ++i)
        ASSERT_EQ(batch[i], crowd.meet[i] ? PairStatus::overlapping : PairStatus::separated) << i;
    }
  }
}

/// A crowd on the move, asked pair by pair and as a batch, with a cache kept from frame to frame, with one of
/// random bits, and with none.
TEST(NativeCache, ChangesNoAnswerWhateverItHolds) {
  Random random(42);
  Crowd crowd = make_crowd(200);
  const auto native = make_native();
  native->build(crowd.solids);
  const auto workspace = native->make_workspace();
  const std::size_t count = crowd.pairs.size();
  std::vector<PairStatus> plain(count), answer(count);
  std::vector<PairCacheEntry> kept(count), alone(count), garbage(count);
  std::size_t kept_axes = 0;
  for (int frame = 0; frame < 40; ++frame) {
    SCOPED_TRACE(frame);
    for (Pose& X : crowd.poses) X.p += random.vector(0.02);
    const Query query{QueryKind::overlap};
    native->evaluate({crowd.pairs, crowd.poses, query}, {plain}, *workspace);
    native->evaluate({crowd.pairs, crowd.poses, query, kept}, {answer}, *workspace);
    ASSERT_EQ(answer, plain);
    for (std::size_t i = 0; i < count; ++i) {
      native->evaluate(
          {std::span(crowd.pairs).subspan(i, 1), crowd.poses, query, std::span(alone).subspan(i, 1)},
          {std::span(answer).subspan(i, 1)}, *workspace);
      for (std::uint32_t& word : garbage[i].data)
        word = static_cast<std::uint32_t>(random.below(1 << 30)) * 7u;
      if (i % 2 == 0) garbage[i].data[3] = kept[i].data[3];  // random bits that pass for an axis
    }
    ASSERT_EQ(answer, plain);
    native->evaluate({crowd.pairs, crowd.poses, query, garbage}, {answer}, *workspace);
    ASSERT_EQ(answer, plain);
  }
  for (const PairCacheEntry& entry : kept) kept_axes += entry.data[3] != 0;
  EXPECT_GT(kept_axes, count / 20);  // it is used
}

}  // namespace
}  // namespace touchstone
