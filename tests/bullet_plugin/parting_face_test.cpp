// The quick test that most pairs end at: pairs that it calls apart are apart.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "touchstone/adapters/bullet_plugin/parting_face.hpp"
#include "touchstone/adapters/bullet_plugin/shape_content.hpp"

namespace touchstone {
namespace {

using namespace TOUCHSTONE_BULLET_NAMESPACE;

/// Boxes whose faces are about to touch, apart or in by what rounding makes and by more, near and far away.
TEST(TOUCHSTONE_SUITE, WhatAFacePartsIsApart) {
  // Numbers as the engine stores them.
  std::mt19937_64 random(11);
  const auto draw = [&] { return 2.0 * static_cast<double>(random() >> 11) * 0x1p-53 - 1.0; };
  const auto number = [&](double middle, double width) { return to_engine(middle + width * draw()); };
  const auto rotation = [&] {
    return btQuaternion(number(0, 1), number(0, 1), number(0, 1), number(0, 1)).normalized();
  };
  native::SolidStore store;
  int parted = 0, apart = 0, wrong = 0;
  for (int i = 0; i < 20000; ++i) {
    // Two boxes whose faces are next to each other across an axis, with a gap or in each other.
    const double far = i % 3 == 0 ? 1e3 : 1.0;
    const btBoxShape a(btVector3(number(0.6, 0.5), number(0.6, 0.5), number(0.6, 0)));
    const btBoxShape b(btVector3(number(0.6, 0), number(0.6, 0.5), number(0.6, 0.5)));
    const btQuaternion turn = rotation();
    const btTransform X_a(turn, btVector3(number(0, far), number(0, far), number(0, far)));
    const int axis = i % 3;
    const double gap = draw() * std::pow(10.0, -1 - 15 * std::abs(draw()));
    const btScalar reach = a.getHalfExtentsWithMargin()[axis] + b.getHalfExtentsWithMargin()[axis];
    const btTransform X_b(i % 2 == 0 ? turn : rotation(),
                          X_a.getOrigin() + X_a.getBasis().getColumn(axis) * (reach + to_engine(gap)));
    // Whether the face parts them, and their exact class.
    PartingFace face;
    const bool is_parted = face.parts(X_a, a.getHalfExtentsWithMargin(), X_b, b.getHalfExtentsWithMargin());
    native::PairAnswer answer;
    store.compute_manifold(*store.acquire(*content_of(a)), from_engine(X_a), *store.acquire(*content_of(b)),
                           from_engine(X_b), {QueryKind::manifold, 0.0, 4, 0.0}, answer);
    const bool is_apart = answer.status == PairStatus::separated;
    parted += is_parted ? 1 : 0;
    apart += is_apart ? 1 : 0;
    wrong += is_parted && !is_apart ? 1 : 0;
  }
  EXPECT_EQ(wrong, 0);
  // It is of use: less in single precision, whose rounding is wider than more of these gaps.
  EXPECT_GT((sizeof(btScalar) == sizeof(double) ? 3 : 4) * parted, apart);
  std::printf("  apart %d, seen %d\n", apart, parted);
}

TEST(TOUCHSTONE_SUITE, AMatrixThatIsNoRotationIsNotJudged) {
  const btVector3 half(1, 1, 1);
  btTransform X_a = btTransform::getIdentity(), X_b = btTransform::getIdentity();
  X_b.setOrigin(btVector3(5, 0, 0));
  PartingFace face;
  EXPECT_TRUE(face.parts(X_a, half, X_b, half));
  btTransform scaled = X_b;
  scaled.setBasis(X_b.getBasis().scaled(btVector3(1, btScalar(1.01), 1)));
  EXPECT_FALSE(face.parts(X_a, half, scaled, half));
  btTransform mirrored = X_b;
  mirrored.setBasis(X_b.getBasis().scaled(btVector3(1, 1, -1)));
  EXPECT_FALSE(face.parts(X_a, half, mirrored, half));
  X_b.setOrigin(btVector3(std::numeric_limits<btScalar>::quiet_NaN(), 0, 0));
  EXPECT_FALSE(face.parts(X_a, half, X_b, half));
  EXPECT_FALSE(face.parts(X_a, btVector3(1, 1, 0), mirrored, half));
}

}  // namespace
}  // namespace touchstone
