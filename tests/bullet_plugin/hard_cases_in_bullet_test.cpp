#include <gmock/gmock.h>

#include <cmath>
#include <iostream>

#include "touchstone/adapters/exact/exact.hpp"
#include "touchstone/adapters/scene_files/pair_file.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/bullet_plugin/collision_scene.hpp"
#include "touchstone/tests/support/ask.hpp"
#include "touchstone/tests/support/scale_of.hpp"

// The named hard cases asked through the engine: with its own check, and with ours. The truth is that of the
// solids and poses as the engine stores them.

namespace touchstone::test {
namespace {

constexpr double kEpsilon = std::numeric_limits<btScalar>::epsilon();

Hexahedron as_stored(const btCollisionShape& shape, bool is_box) {
  if (is_box) {
    const btVector3 half = static_cast<const btBoxShape&>(shape).getHalfExtentsWithMargin();
    return Hexahedron::from_size(2.0 * from_engine(half));
  }
  std::array<Vector3, 8> v;
  for (int i = 0; i < 8; ++i)
    v[i] = from_engine(static_cast<const btConvexHullShape&>(shape).getScaledPoint(i));
  return Hexahedron::from_vertices(v, WarpPolicy::accept);
}

Pose as_stored(const btTransform& X) {
  Pose out;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) out.R(i, k) = X.getBasis()[i][k];
  out.p = from_engine(X.getOrigin());
  return out;
}

struct Truth {
  bool contact;
  double separation, scale;
};

std::unique_ptr<btCollisionShape> make_shape(const Hexahedron& solid) {
  if (!solid.is_box()) return make_hull(solid.vertices());
  const Vector3& half = solid.half_extents();
  return make_box(2 * half.x(), 2 * half.y(), 2 * half.z());
}

enum class Verdict { right, wrong_class, wrong_depth };

/// The tolerance, of the pair's place and size: for us the rounding of the engine's numbers, the engine a
/// lot.
double tolerance(bool native) { return native ? 64 * kEpsilon : 1e-4; }

/// The class, and the depth of a contact; distances are not judged.
Verdict judge(const Contacts& contacts, const Truth& truth, bool native) {
  const btManifoldPoint* const deepest = contacts.deepest();
  const bool contact = deepest != nullptr && deepest->getDistance() <= 0;
  if (contact != truth.contact) return Verdict::wrong_class;
  if (contact && !(std::abs(deepest->getDistance() - truth.separation) <= tolerance(native) * truth.scale))
    return Verdict::wrong_depth;
  return Verdict::right;
}

/// Cases that the engine cannot hold: rounding takes a side of theirs.
std::vector<std::string> flattened_by_storing() {
  std::vector<std::string> scales = {"denormal", "least-normal", "1e-160"};
  if (!kDouble) scales.insert(scales.end(), {"2^511", "2^1000"});
  std::vector<std::string> ids;
  for (const std::string& scale : scales)
    for (const char* place : {"touch", "deep", "apart"}) ids.push_back("scale-" + scale + "-" + place);
  if (!kDouble) ids.insert(ids.end(), {"thin-slab-turned", "thin-paper"});
  return ids;
}

std::vector<std::string> of_another_class_once_stored() {
  if (kDouble) return {};
  return {"far-1e6-apart",
          "far-2^30-apart",
          "far-1e12-apart",
          "far-1e15-apart",
          "scale-turned-1e-8",
          "touching-edge-crossing-apart-2^-30",
          "touching-vertex-face-apart-2^-30",
          "touching-edge-crossing-apart-2^-45",
          "touching-vertex-face-apart-2^-45",
          "touching-edge-crossing-apart-2^-50",
          "touching-vertex-face-apart-2^-50"};
}

TEST(TOUCHSTONE_SUITE, HardCasesAreRightWithOurCheckWhereTheEnginesIsWrong) {
  BackendRegistry registry;
  register_exact(registry);
  const auto exact = registry.make_narrowphase("exact");
  int cases = 0, wrong_class[2] = {}, wrong_depth[2] = {};
  std::vector<std::string> flattened, of_another_class, ours_wrong;
  for (const char* file :
       {"containment", "coplanar", "far", "hexahedra", "near_parallel", "scale", "thin", "touching"}) {
    for (const PairCase& hard : load_pairs(std::string(TOUCHSTONE_HARD_CASES) + "/" + file + ".json")) {
      const PosedPair& pair = *hard.pair;
      Truth truth{};
      Verdict verdicts[2];
      bool judged = true;
      // The truth is of the solids as the engine stores them, in its precision; its check is asked first,
      // then ours.
      for (const bool native : {false, true}) {
        CollisionScene scene(native);
        for (int i = 0; i < 2; ++i) scene.add(make_shape(pair.solids[i]), pair.X_WS[i]);
        try {
          const std::vector<Hexahedron> stored = {as_stored(*scene.shapes[0], pair.solids[0].is_box()),
                                                  as_stored(*scene.shapes[1], pair.solids[1].is_box())};
          const Pose poses[2] = {as_stored(scene.objects[0]->getWorldTransform()),
                                 as_stored(scene.objects[1]->getWorldTransform())};
          exact->build(stored);
          const Answer answer = ask(*exact, poses, {.kind = QueryKind::distance});
          truth = {answer.status == PairStatus::overlapping, answer.geometry.separation,
                   scale_of(stored[0], poses[0], stored[1], poses[1])};
        } catch (const InputError&) {  // rounding flattened it
          judged = false;
          break;
        }
        verdicts[native] = judge(scene.query(), truth, native);
        EXPECT_EQ(scene.plugin ? scene.plugin->statistics().checks : 0u, native ? 1u : 0u) << hard.id;
      }
      // Verdicts by check, and the cases that storing has changed.
      if (!judged) {
        flattened.push_back(hard.id);
        continue;
      }
      ++cases;
      for (const bool native : {false, true}) {
        wrong_class[native] += verdicts[native] == Verdict::wrong_class;
        wrong_depth[native] += verdicts[native] == Verdict::wrong_depth;
      }
      if (verdicts[1] != Verdict::right) ours_wrong.push_back(hard.id);
      if (truth.contact != (hard.exact->pair_class != PairClass::separated))
        of_another_class.push_back(hard.id);
    }
  }
  // Ours has none wrong; the engine as many as ever.
  std::cout << cases << " cases: engine's own " << wrong_class[0] << " of the wrong class, " << wrong_depth[0]
            << " of wrong depth; ours " << wrong_class[1] << ", " << wrong_depth[1] << "\n";
  EXPECT_THAT(ours_wrong, testing::IsEmpty());
  EXPECT_EQ(cases + flattened.size(), 144u);
  EXPECT_THAT(flattened, testing::UnorderedElementsAreArray(flattened_by_storing()));
  EXPECT_THAT(of_another_class, testing::UnorderedElementsAreArray(of_another_class_once_stored()));
  EXPECT_EQ(wrong_class[0], kDouble ? 31 : 29);
  EXPECT_EQ(wrong_depth[0], kDouble ? 7 : 6);
}

}  // namespace
}  // namespace touchstone::test
