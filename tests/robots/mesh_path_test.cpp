#include "touchstone/adapters/robots/mesh_path.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "touchstone/tests/support/refusal.hpp"

namespace touchstone {
namespace {

using std::filesystem::path;
using testing::HasSubstr;

/// share/checkout/{package.xml, urdf/arm.urdf, meshes/link.stl}, other/hand/finger.stl and secret.stl.
class MeshPath : public testing::Test {
 protected:
  void SetUp() override {
    root_ = path(testing::TempDir()) /
            ("mesh_path." + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    for (const char* file : {"share/checkout/package.xml", "share/checkout/urdf/arm.urdf",
                             "share/checkout/meshes/link.stl", "other/hand/finger.stl", "other/secret.stl"}) {
      create_directories((root_ / file).parent_path());
      std::ofstream(root_ / file) << "<package><name>my_arm</name></package>";
    }
    robot_ = root_ / "share/checkout/urdf/arm.urdf";
  }
  void TearDown() override { remove_all(root_); }
  std::string error(const std::string& uri) {
    return refusal_of([&] { mesh_path(uri, robot_, {root_ / "other"}); });
  }

  path root_, robot_;
};

TEST_F(MeshPath, PackagesAreFoundByNameManifestAndEnvironment) {
  EXPECT_TRUE(equivalent(mesh_path("package://my_arm/meshes/link.stl", robot_, {}),
                         root_ / "share/checkout/meshes/link.stl"));
  EXPECT_TRUE(equivalent(mesh_path("package://checkout/meshes/link.stl", robot_, {}),
                         root_ / "share/checkout/meshes/link.stl"));
  const path finger = root_ / "other/hand/finger.stl";
  EXPECT_TRUE(equivalent(mesh_path("package://hand/finger.stl", robot_, {root_ / "other"}), finger));
  EXPECT_TRUE(equivalent(mesh_path("model://hand/finger.stl", robot_, {root_ / "other/hand"}), finger));
  EXPECT_THAT(refusal_of([&] { mesh_path("package://hand/finger.stl", robot_, {}); }),
              HasSubstr("not found; looked for package 'hand'"));
  ASSERT_EQ(setenv("ROS_PACKAGE_PATH", ("/nowhere:" + (root_ / "other").string()).c_str(), 1), 0);
  EXPECT_TRUE(equivalent(mesh_path("package://hand/finger.stl", robot_, {}), finger));
  ASSERT_EQ(unsetenv("ROS_PACKAGE_PATH"), 0);
}

TEST_F(MeshPath, RelativeAndFilePathsAreTaken) {
  EXPECT_TRUE(
      equivalent(mesh_path("../meshes/link.stl", robot_, {}), root_ / "share/checkout/meshes/link.stl"));
  const path finger = root_ / "other/hand/finger.stl";
  EXPECT_EQ(mesh_path("file://" + finger.string(), robot_, {}), finger);
}

// As many files have them that others wrote: from the package's folder, and no further up.
TEST_F(MeshPath, RelativePathsMayBeThePackages) {
  const path link = root_ / "share/checkout/meshes/link.stl";
  EXPECT_TRUE(equivalent(mesh_path("meshes/link.stl", robot_, {}), link));
  EXPECT_TRUE(equivalent(mesh_path("./a/../meshes/link.stl", robot_, {}), link));
  std::ofstream(root_ / "share/outer.stl") << "solid";
  EXPECT_THAT(error("outer.stl"), HasSubstr("there is no file"));
  EXPECT_THAT(error("../outer.stl"), HasSubstr("there is no file"));
  remove(root_ / "share/checkout/package.xml");
  EXPECT_THAT(error("meshes/link.stl"), HasSubstr("there is no file"));
}

// As exporters write names with spaces: a name that is there as it is written comes first.
TEST_F(MeshPath, UrisMayBePercentEncoded) {
  const path middle = root_ / "other/left hand/middle finger.stl", literal = root_ / "other/hand/a%20b.stl";
  create_directories(middle.parent_path());
  for (const path& file : {middle, literal}) std::ofstream(file) << "solid";
  const std::vector<path> packages = {root_ / "other"};
  for (const char* uri :
       {"package://left hand/middle finger.stl", "package://left%20hand/middle%20finger.stl"})
    EXPECT_TRUE(equivalent(mesh_path(uri, robot_, packages), middle)) << uri;
  EXPECT_EQ(mesh_path("package://hand/a%20b.stl", robot_, packages), literal);
  EXPECT_THAT(error("package://hand/a/%2e%2e/%2E%2E/secret.stl"), HasSubstr("leaves its package"));
  EXPECT_THAT(error("package://hand/finger.stl%00"), HasSubstr("not found"));
  EXPECT_THAT(error("package://hand/finger.stl%2"), HasSubstr("not found"));
}

TEST_F(MeshPath, NoPathLeavesItsPackage) {
  EXPECT_THAT(error("package://hand/../secret.stl"), HasSubstr("leaves its package"));
  EXPECT_THAT(error("package://hand/a/../../secret.stl"), HasSubstr("leaves its package"));
  EXPECT_THAT(error("package://hand//etc/passwd"), HasSubstr("leaves its package"));
  EXPECT_THAT(error("package://../secret.stl"), HasSubstr("names no package"));
  EXPECT_THAT(error("package://hand"), HasSubstr("names no package"));
}

TEST_F(MeshPath, WhatIsNotThereIsNamed) {
  EXPECT_THAT(error("package://hand/thumb.stl"), HasSubstr("mesh 'package://hand/thumb.stl': not found"));
  EXPECT_THAT(error("package://hand/" + std::string(300, 'a')), HasSubstr("not found"));  // too long a name
  EXPECT_THAT(error("thumb.stl"), HasSubstr("thumb.stl, nor in a folder above up to one with a package.xml"));
  EXPECT_THAT(error(""), HasSubstr("there is no file"));
  EXPECT_THAT(error("https://example.org/a.stl"), HasSubstr("known are package://"));
}

}  // namespace
}  // namespace touchstone
