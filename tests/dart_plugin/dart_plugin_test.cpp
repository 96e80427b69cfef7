#include "touchstone/adapters/dart_plugin/dart_plugin.hpp"

#include <assimp/scene.h>
#include <gmock/gmock.h>

#include <dart/collision/collision.hpp>
#include <dart/constraint/ConstraintSolver.hpp>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/BoxShape.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/MeshShape.hpp>
#include <dart/dynamics/ShapeNode.hpp>
#include <dart/dynamics/SimpleFrame.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/dynamics/SphereShape.hpp>
#include <dart/dynamics/WeldJoint.hpp>
#include <dart/simulation/World.hpp>
#include <map>
#include <random>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/tests/support/ask.hpp"
#include "touchstone/tests/support/random_poses.hpp"

namespace touchstone {
namespace {

using namespace dart;
using dynamics::SimpleFrame;

constexpr double kTolerance = 1e-12;

std::shared_ptr<dynamics::BoxShape> box(double x, double y, double z) {
  return std::make_shared<dynamics::BoxShape>(Eigen::Vector3d(x, y, z));
}

/// As a loader of STL gives it: each triangle has vertices of its own.
std::shared_ptr<dynamics::MeshShape> mesh(const std::array<Vector3, 8>& vertices, double scale = 1.0) {
  const int quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                           {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  auto* const part = new aiMesh;
  part->mNumVertices = 36, part->mVertices = new aiVector3D[36];
  part->mNumFaces = 12, part->mFaces = new aiFace[12];
  for (int f = 0; f < 12; ++f) {
    part->mFaces[f].mNumIndices = 3, part->mFaces[f].mIndices = new unsigned[3];
    for (int k = 0; k < 3; ++k) {
      const Vector3& v = vertices[quads[f / 2][k == 0 ? 0 : k + f % 2]];
      part->mVertices[3 * f + k] =
          aiVector3D(static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()));
      part->mFaces[f].mIndices[k] = 3 * f + k;
    }
  }
  auto* const scene = new aiScene;  // the shape's, which releases it
  scene->mNumMeshes = 1, scene->mMeshes = new aiMesh* [1] { part };
  scene->mRootNode = new aiNode;
  scene->mRootNode->mNumMeshes = 1, scene->mRootNode->mMeshes = new unsigned[1]{0};
  return std::make_shared<dynamics::MeshShape>(Eigen::Vector3d::Constant(scale), scene);
}

std::array<Vector3, 8> cube() { return Hexahedron::from_size({1, 1, 1}).vertices(); }

Eigen::Isometry3d isometry(const Pose& X) {
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) out(i, k) = X.R(i, k);
  for (int k = 0; k < 3; ++k) out(k, 3) = X.p[k];
  return out;
}

/// Frames of one shape each in a group of our detector.
struct Group {
  explicit Group(const std::vector<dynamics::ShapePtr>& shapes, const DartOptions& options = {})
      : detector(make_dart_detector(options)), group(detector->createCollisionGroupAsSharedPtr()) {
    for (const dynamics::ShapePtr& shape : shapes) {
      frames.push_back(std::make_shared<SimpleFrame>(dynamics::Frame::World()));
      frames.back()->setShape(shape);
      group->addShapeFrame(frames.back().get());
    }
  }
  void place(int i, const Eigen::Isometry3d& X_WS) { frames[i]->setTransform(X_WS); }
  void place(int i, double x, double y = 0.0, double z = 0.0) {
    place(i, Eigen::Isometry3d(Eigen::Translation3d(x, y, z)));
  }

  std::shared_ptr<collision::CollisionDetector> detector;
  std::vector<std::shared_ptr<SimpleFrame>> frames;
  std::shared_ptr<collision::CollisionGroup> group;
};

TEST(DartPlugin, TheNormalPointsFromObject2ToObject1AndThePointIsHalfWay) {
  for (const bool first_is_mesh : {false, true}) {
    for (const bool second_is_mesh : {false, true}) {
      const auto shape = [](bool is_mesh) -> dynamics::ShapePtr {
        if (is_mesh) return mesh(cube());
        return box(1, 1, 1);
      };
      Group boxes({shape(first_is_mesh), shape(second_is_mesh)});
      boxes.place(1, 0.75);
      const std::uint64_t before = dart_native_checks();
      collision::CollisionResult result;
      EXPECT_TRUE(boxes.group->collide(collision::CollisionOption(), &result));
      EXPECT_EQ(dart_native_checks() - before, 1u);
      ASSERT_EQ(result.getNumContacts(), 4u);
      for (const collision::Contact& contact : result.getContacts()) {
        const bool in_order = contact.collisionObject1->getShapeFrame() == boxes.frames[0].get();
        EXPECT_NEAR(contact.normal.x(), in_order ? -1.0 : 1.0, kTolerance);
        EXPECT_NEAR(contact.penetrationDepth, 0.25, kTolerance);
        EXPECT_NEAR(contact.point.x(), 0.375, kTolerance);
        EXPECT_NEAR(std::abs(contact.point.y()), 0.5, kTolerance);
      }
    }
  }
}

TEST(DartPlugin, TouchingIsContactAndAnythingApartIsNot) {
  Group boxes({box(1, 1, 1), box(1, 1, 1)});
  boxes.place(1, 1.0);
  EXPECT_TRUE(boxes.group->collide());
  boxes.place(1, 1.0 + 0x1p-52);
  EXPECT_FALSE(boxes.group->collide());
}

TEST(DartPlugin, AMeshOfAHexahedronIsSolidAndScaled) {
  Group shapes({mesh(cube(), 4.0), box(1, 1, 1)});  // the box is inside: to FCL the surfaces are apart
  EXPECT_TRUE(shapes.group->collide());
  shapes.place(1, 2.4);
  EXPECT_TRUE(shapes.group->collide());
  shapes.place(1, 2.6);
  EXPECT_FALSE(shapes.group->collide());
}

TEST(DartPlugin, OtherShapesAndDistancesAreLeftToFcl) {
  Group shapes({box(1, 1, 1), std::make_shared<dynamics::SphereShape>(0.5)});
  const auto theirs = collision::FCLCollisionDetector::create();
  const auto their_group = theirs->createCollisionGroupAsSharedPtr();
  for (const auto& frame : shapes.frames) their_group->addShapeFrame(frame.get());
  shapes.place(1, 0.75);
  const std::uint64_t before = dart_native_checks();
  collision::CollisionResult ours, reference;
  EXPECT_EQ(shapes.group->collide(collision::CollisionOption(), &ours),
            their_group->collide(collision::CollisionOption(), &reference));
  EXPECT_EQ(ours.getNumContacts(), reference.getNumContacts());
  EXPECT_GT(ours.getNumContacts(), 0u);
  EXPECT_EQ(dart_native_checks(), before);
  shapes.place(1, 3.0);
  EXPECT_EQ(shapes.group->distance(), their_group->distance());
  EXPECT_GT(shapes.group->distance(), 1.0);
}

TEST(DartPlugin, OptionsHoldAsTheyDoForDart) {
  // A filter that lets nothing through.
  struct None final : collision::CollisionFilter {
    bool ignoresCollision(const collision::CollisionObject*,
                          const collision::CollisionObject*) const override {
      return true;
    }
  };
  Group boxes({box(1, 1, 1), box(1, 1, 1), box(1, 1, 1)});
  boxes.place(1, 0.75), boxes.place(2, 0.0, 0.75);
  collision::CollisionResult result;
  EXPECT_FALSE(
      boxes.group->collide(collision::CollisionOption(true, 100, std::make_shared<None>()), &result));
  EXPECT_EQ(result.getNumContacts(), 0u);
  // The most contacts that are asked for.
  boxes.group->collide(collision::CollisionOption(true, 6), &result);
  EXPECT_EQ(result.getNumContacts(), 6u);
  result.clear();
  boxes.group->collide(collision::CollisionOption(), &result);
  EXPECT_GE(result.getNumContacts(), 9u);
  // A yes or no takes one check.
  const std::uint64_t before = dart_native_checks();
  EXPECT_TRUE(boxes.group->collide());
  EXPECT_EQ(dart_native_checks() - before, 1u);  // the first is enough
  // Options of our own.
  Group few({box(1, 1, 1), box(1, 1, 1)}, {.most_contacts = 2});
  few.place(1, 0.75);
  result.clear();
  few.group->collide(collision::CollisionOption(), &result);
  EXPECT_EQ(result.getNumContacts(), 2u);
  EXPECT_THROW(make_dart_detector({.most_contacts = 0}), InputError);
  EXPECT_THROW(make_dart_detector({.most_contacts = 9}), InputError);
}

TEST(DartPlugin, TwoGroupsAreCheckedAgainstEachOther) {
  Group boxes({box(1, 1, 1), box(1, 1, 1), box(1, 1, 1)});
  const auto other = boxes.detector->createCollisionGroupAsSharedPtr();
  boxes.group->removeShapeFrame(boxes.frames[2].get());
  other->addShapeFrame(boxes.frames[2].get());
  boxes.place(1, 0.75), boxes.place(2, 5.0);
  EXPECT_FALSE(boxes.group->collide(other.get()));
  boxes.place(2, 1.5);
  EXPECT_TRUE(boxes.group->collide(other.get()));
}

TEST(DartPlugin, PairsAreThoseOfNativeAtAnyPose) {
  // The same boxes in native and in DART.
  BackendRegistry registry;
  register_core(registry);
  const auto native = registry.make_narrowphase("native");
  const std::array solids = {Hexahedron::from_size({1, 0.5, 2}), Hexahedron::from_size({1, 1, 1})};
  native->build(solids);
  Group boxes({box(1, 0.5, 2), box(1, 1, 1)});
  std::mt19937_64 random(20261123);
  int overlapping = 0;
  for (int i = 0; i < 2000; ++i) {
    // In random poses: the same class and depth.
    const std::array poses = {random_pose(random, 1.0), random_pose(random, 1.0)};
    for (int k = 0; k < 2; ++k) boxes.place(k, isometry(poses[k]));
    const Answer expected = ask(*native, poses, {.kind = QueryKind::manifold, .max_separation = 0.0});
    collision::CollisionResult result;
    EXPECT_EQ(boxes.group->collide(collision::CollisionOption(), &result),
              expected.status == PairStatus::overlapping)
        << i;
    if (expected.status != PairStatus::overlapping) continue;
    ++overlapping;
    double deepest = 0.0;
    for (const collision::Contact& contact : result.getContacts())
      deepest = std::max(deepest, contact.penetrationDepth);
    EXPECT_NEAR(deepest, -expected.geometry.separation, 1e-14) << i;
  }
  EXPECT_GT(overlapping, 200);
}

TEST(DartPlugin, MoreShapesThanAThreadRemembersAreCheckedAsTheyAre) {
  constexpr int kShapes = 1500;  // a row: each is in the next by 0.25
  std::vector<dynamics::ShapePtr> shapes;
  for (int i = 0; i < kShapes; ++i) shapes.push_back(box(1.0, 1.0 + 0x1p-10 * i, 1.0));
  Group boxes(shapes);
  for (int i = 0; i < kShapes; ++i) boxes.place(i, 0.75 * i);
  collision::CollisionResult result;
  boxes.group->collide(collision::CollisionOption(true, 100000), &result);
  EXPECT_EQ(result.getNumContacts(), 4u * (kShapes - 1));
  for (const collision::Contact& contact : result.getContacts()) {
    EXPECT_NEAR(contact.penetrationDepth, 0.25, kTolerance);
    const auto side = [](const collision::CollisionObject& object) {
      return static_cast<const dynamics::BoxShape&>(*object.getShape()).getSize().y();
    };
    const double less = std::min(side(*contact.collisionObject1), side(*contact.collisionObject2));
    EXPECT_NEAR(std::abs(contact.point.y()), 0.5 * less, kTolerance);
  }
}

TEST(DartPlugin, AStackOfBoxesStandsInAWorldThatNamesItsDetector) {
  // The detector goes by its name; naming it twice does no harm.
  register_dart_detector();
  register_dart_detector();
  const auto detector = collision::CollisionDetector::getFactory()->create("touchstone");
  ASSERT_NE(detector, nullptr);
  EXPECT_EQ(detector->getType(), "touchstone");
  EXPECT_EQ(detector->cloneWithoutCollisionObjects()->getType(), "touchstone");
  const auto world = simulation::World::create();
  world->getConstraintSolver()->setCollisionDetector(detector);
  // A floor, and five boxes on each other.
  const auto add = [&](const Eigen::Vector3d& size, double height, bool moves) {
    const auto skeleton = dynamics::Skeleton::create("at " + std::to_string(height));
    dynamics::BodyNode* body = nullptr;
    if (moves)
      body = skeleton->createJointAndBodyNodePair<dynamics::FreeJoint>().second;
    else
      body = skeleton->createJointAndBodyNodePair<dynamics::WeldJoint>().second;
    body->createShapeNodeWith<dynamics::CollisionAspect, dynamics::DynamicsAspect>(
        std::make_shared<dynamics::BoxShape>(size));
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.translation().z() = height;
    body->getParentJoint()->setTransformFromParentBodyNode(X);
    world->addSkeleton(skeleton);
    return skeleton;
  };
  add({10, 10, 1}, -0.5, false);
  std::vector<dynamics::SkeletonPtr> boxes;
  for (int i = 0; i < 5; ++i) boxes.push_back(add({0.5, 0.5, 0.5}, 0.25 + 0.5 * i, true));
  // They stand for a second, by our checks.
  const std::uint64_t before = dart_native_checks();
  for (int step = 0; step < 1000; ++step) world->step();
  EXPECT_GE(dart_native_checks() - before, 5000u);
  for (int i = 0; i < 5; ++i)
    EXPECT_NEAR(boxes[i]->getBodyNode(0)->getTransform().translation().z(), 0.25 + 0.5 * i, 0.01) << i;
}

}  // namespace
}  // namespace touchstone
