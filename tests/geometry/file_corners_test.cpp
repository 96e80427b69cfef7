// Corners as files write them are solids: whatever the digits, wherever the block stands, in any order.

#include "touchstone/tests/support/file_corners.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

using file_corners::Corners;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr int kBlocks = 300;

// The four corners of each face, whatever the labels.
std::set<std::set<std::array<double, 3>>> faces(const std::array<Vector3, 8>& vertices) {
  std::set<std::set<std::array<double, 3>>> all;
  for (const auto& quad : Hexahedron::kFaceVertices) {
    std::set<std::array<double, 3>> face;
    for (int i : quad) face.insert({vertices[i].x(), vertices[i].y(), vertices[i].z()});
    all.insert(face);
  }
  return all;
}

// How many of kBlocks load, in the order of Hexahedron or in a random one, with the faces that the block has.
int loaded(const file_corners::Format& format, bool in_random_order, std::string& first_error) {
  std::mt19937_64 random(13);
  int count = 0;
  for (int i = 0; i < kBlocks; ++i) {
    const Corners written = file_corners::in_file(file_corners::block(random, i), format, random);
    const Corners given = in_random_order ? file_corners::shuffled(written, random) : written;
    try {
      const Hexahedron solid = Hexahedron::from_vertices(given);
      EXPECT_LE(solid.out_of_plane(), 0.01 * solid.size());
      if (faces(solid.vertices()) == faces(written)) ++count;
    } catch (const InputError& error) {
      if (first_error.empty()) first_error = error.what();
    }
  }
  return count;
}

TEST(FileCorners, TurnedBlocksLoadWithAnyDigits) {
  for (const file_corners::Format& format : file_corners::formats()) {
    std::string error;
    EXPECT_EQ(loaded(format, false, error), kBlocks) << format.name << ": " << error;
  }
}

TEST(FileCorners, TurnedBlocksLoadWithAnyDigitsInAnyOrder) {
  for (const file_corners::Format& format : file_corners::formats()) {
    std::string error;
    EXPECT_EQ(loaded(format, true, error), kBlocks) << format.name << ": " << error;
  }
}

}  // namespace
}  // namespace touchstone
