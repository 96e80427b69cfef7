#include "touchstone/adapters/gltf/gltf.hpp"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "output_fixture.hpp"
#include "touchstone/tests/support/refusal.hpp"

namespace touchstone {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

std::string decode_base64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6 | static_cast<std::uint32_t>(digits.find(c));
    if ((count += 6) >= 8) bytes += static_cast<char>(bits >> (count -= 8) & 0xff);
  }
  return bytes;
}

/// A glTF file as the specification lays it out; what is out of bounds or of another type throws.
class Loaded {
 public:
  explicit Loaded(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    document = json::parse(in);
    const std::string uri = document.at("buffers").at(0).at("uri");
    const std::string head = "data:application/octet-stream;base64,";
    EXPECT_EQ(uri.substr(0, head.size()), head);
    bytes_ = decode_base64(uri.substr(head.size()));
    EXPECT_EQ(bytes_.size(), document["buffers"][0]["byteLength"].get<std::size_t>());
  }

  json document;

  std::vector<float> floats(std::size_t accessor, const std::string& type) const {
    const json& a = document.at("accessors").at(accessor);
    EXPECT_EQ(a.at("type"), type);
    EXPECT_EQ(a.at("componentType"), 5126);
    const std::size_t components = type == "SCALAR" ? 1 : type == "VEC3" ? 3 : 4;
    const auto values = read<float>(a, a.at("count").get<std::size_t>() * components);
    for (std::size_t i = 0; i < values.size(); ++i) {
      EXPECT_GE(values[i], a.at("min").at(i % components).get<float>());
      EXPECT_LE(values[i], a.at("max").at(i % components).get<float>());
    }
    return values;
  }

  std::vector<std::uint32_t> indices(std::size_t accessor) const {
    const json& a = document.at("accessors").at(accessor);
    EXPECT_EQ(a.at("type"), "SCALAR");
    EXPECT_EQ(a.at("componentType"), 5125);
    return read<std::uint32_t>(a, a.at("count").get<std::size_t>());
  }

  std::size_t node(const std::string& name) const {
    const json& nodes = document.at("nodes");
    for (std::size_t i = 0; i < nodes.size(); ++i)
      if (nodes[i].at("name") == name) return i;
    throw std::runtime_error("no node " + name);
  }

  /// The sampler of a node's `path`, or null.
  const json* sampler(std::size_t node, const std::string& path) const {
    const json& animation = document.at("animations").at(0);
    for (const json& channel : animation.at("channels"))
      if (channel.at("target").at("node") == node && channel.at("target").at("path") == path)
        return &animation.at("samplers").at(channel.at("sampler").get<std::size_t>());
    return nullptr;
  }

 private:
  template <class Value>
  std::vector<Value> read(const json& accessor, std::size_t count) const {
    const json& view = document.at("bufferViews").at(accessor.at("bufferView").get<std::size_t>());
    EXPECT_EQ(view.at("buffer"), 0);
    const std::size_t offset = view.at("byteOffset");
    EXPECT_EQ(offset % sizeof(Value), 0u);
    EXPECT_EQ(view.at("byteLength"), count * sizeof(Value));
    if (offset + count * sizeof(Value) > bytes_.size()) throw std::runtime_error("view out of the buffer");
    std::vector<Value> values(count);
    std::memcpy(values.data(), bytes_.data() + offset, count * sizeof(Value));
    return values;
  }

  std::string bytes_;
};

std::shared_ptr<const HexahedronTree> two_solids(const std::string& name) {
  // A frustum, a box beside it, and a solid whose faces are warped.
  std::vector<Vector3> frustum, warped;
  for (int i = 0; i < 8; ++i) {
    const double x = i & 4 ? 1 : -1, y = i & 2 ? 1 : -1, z = i & 1 ? 1 : -1;
    frustum.emplace_back(x * (z > 0 ? 0.5 : 1), y * (z > 0 ? 0.5 : 1), z);
    warped.emplace_back(x, y, z + (i == 7 ? 0.3 : 0.0));
  }
  Pose X_OS;
  X_OS.R = rotation_from_quaternion(1, 2, 3, 4);
  X_OS.p = {0, 5, 0};
  return std::make_shared<HexahedronTree>(
      std::vector<PlacedHexahedron>{{"frustum", Hexahedron::from_vertices(frustum), {}},
                                    {"box", Hexahedron::from_size({1, 2, 3}), X_OS},
                                    {"warped", Hexahedron::from_vertices(warped, WarpPolicy::accept), {}}},
      name);
}

Recording make_recording(std::size_t frames, std::uint32_t objects) {
  Recording recording;
  for (std::uint32_t i = 0; i < objects; ++i) recording.objects.push_back("object " + std::to_string(i));
  for (const MadeFrame& made : make_frames(frames, objects, 50)) {
    RecordedFrame frame{made.frame, 3.0 + made.time, 0, {}, {}};
    for (const ShownPose& pose : made.poses) frame.poses.push_back({pose.object.slot, pose.X_WO});
    recording.frames.push_back(std::move(frame));
  }
  return recording;
}

TEST(Gltf, EveryFrameOfEveryObject) {
  // Trees come in any order, one of them of no object.
  const TemporaryFile file("run.gltf");
  const Recording recording = make_recording(40, 3);
  const std::array trees{two_solids("object 2"), two_solids("object 0"), two_solids("object 1"),
                         two_solids("not there")};
  write_gltf(file.path(), recording, trees);
  // The document has one node for each object of the recording, below one root.
  const Loaded loaded(file.path());
  EXPECT_EQ(loaded.document.at("asset").at("version"), "2.0");
  EXPECT_EQ(loaded.document.at("scenes").at(0).at("nodes"), json::array({0}));
  EXPECT_EQ(loaded.document.at("nodes").at(0).at("children"), json::array({1, 2, 3}));
  // Each object's keys: times, places and turns, and these the short way round.
  for (std::uint32_t object = 0; object < 3; ++object) {
    const std::size_t node = loaded.node("object " + std::to_string(object));
    const json* move = loaded.sampler(node, "translation");
    const json* turn = loaded.sampler(node, "rotation");
    ASSERT_TRUE(move && turn);
    EXPECT_FALSE(loaded.sampler(node, "scale"));
    const auto times = loaded.floats(move->at("input"), "SCALAR");
    const auto translations = loaded.floats(move->at("output"), "VEC3");
    const auto rotations = loaded.floats(turn->at("output"), "VEC4");
    ASSERT_EQ(times.size(), 40u);
    ASSERT_EQ(translations.size(), 120u);
    ASSERT_EQ(rotations.size(), 160u);
    for (std::size_t k = 0; k < 40; ++k) {
      EXPECT_EQ(times[k], static_cast<float>(recording.frames[k].time - 3.0));
      const Pose& X_WO = recording.frames[k].poses[object].X_WO;
      for (int i = 0; i < 3; ++i) EXPECT_EQ(translations[3 * k + i], static_cast<float>(X_WO.p(i)));
      const float* q = &rotations[4 * k];
      const Matrix3 R = rotation_from_quaternion(q[3], q[0], q[1], q[2]);
      EXPECT_LT((R - X_WO.R).cwiseAbs().maxCoeff(), 8 * 0x1p-24);  // 4 floats, each rounded
      if (k > 0) {
        EXPECT_GE(q[0] * q[-4] + q[1] * q[-3] + q[2] * q[-2] + q[3] * q[-1], 0.0F);
      }
    }
  }
}

TEST(Gltf, MeshesAreClosedAndFaceOutwards) {
  const TemporaryFile file("mesh.gltf");
  const auto tree = two_solids("object 0");
  write_gltf(file.path(), make_recording(2, 1), std::array{tree});
  const Loaded loaded(file.path());
  const json& primitive = loaded.document.at("meshes").at(0).at("primitives").at(0);
  const auto positions = loaded.floats(primitive.at("attributes").at("POSITION"), "VEC3");
  const auto indices = loaded.indices(primitive.at("indices"));
  ASSERT_EQ(positions.size(), 3u * 8u * 3u);
  ASSERT_EQ(indices.size(), 3u * 12u * 3u);
  const auto corner = [&](std::size_t i) {
    const std::size_t at = 3 * std::size_t{indices[i]};
    return Vector3(positions.at(at), positions.at(at + 1), positions.at(at + 2));
  };
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (std::size_t solid = 0; solid < 3; ++solid) {
    const PlacedHexahedron& placed = tree->solids()[solid];
    double volume = 0.0;
    for (std::size_t t = 36 * solid; t < 36 * (solid + 1); t += 3) {
      const Vector3 a = corner(t), b = corner(t + 1), c = corner(t + 2);
      volume += dot(a - placed.X_OS.p, cross(b - placed.X_OS.p, c - placed.X_OS.p)) / 6;
      for (std::size_t i = 0; i < 3; ++i) ++edges[{indices[t + i], indices[t + (i + 1) % 3]}];
      // No corner of its solid is above a triangle: the surface is the hull.
      const Vector3 n = cross(b - a, c - a);
      for (std::size_t i = 36 * solid; i < 36 * (solid + 1); ++i) EXPECT_LE(dot(n, corner(i) - a), 1e-5);
    }
    // The frustum: h/3 (A + a + sqrt(A a)). The warped one: its top folds along the diagonal through the
    // lifted corner, and rises by 0.3 / 3 on average over 2 x 2.
    const std::array<double, 3> volumes{2.0 / 3 * (4 + 1 + 2), 6.0, 8.4};
    EXPECT_NEAR(volume, volumes[solid], 1e-5);
  }
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1);
    EXPECT_TRUE(edges.contains({edge.second, edge.first}));
  }
}

TEST(Gltf, WhatComesAndGoesIsSizedToNothing) {
  const TemporaryFile file("comes.gltf");
  Recording recording = make_recording(6, 2);
  for (const std::size_t frame : {0, 1, 4}) recording.frames[frame].poses.pop_back();
  write_gltf(file.path(), recording, std::array{two_solids("object 0"), two_solids("object 1")});
  const Loaded loaded(file.path());
  EXPECT_FALSE(loaded.sampler(loaded.node("object 0"), "scale"));
  const json* sampler = loaded.sampler(loaded.node("object 1"), "scale");
  ASSERT_TRUE(sampler);
  EXPECT_EQ(sampler->at("interpolation"), "STEP");
  const auto scales = loaded.floats(sampler->at("output"), "VEC3");
  for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(scales[3 * k], k == 0 || k == 1 || k == 4 ? 0.0F : 1.0F);
}

TEST(Gltf, WhatStandsHasNoSamplersAndZIsUp) {
  const TemporaryFile file("stands.gltf");
  Recording recording = make_recording(3, 1);
  for (RecordedFrame& frame : recording.frames) frame.poses[0].X_WO = at(0, 0, 2);
  write_gltf(file.path(), recording, std::array{two_solids("object 0")});
  const Loaded loaded(file.path());
  EXPECT_FALSE(loaded.document.contains("animations"));
  EXPECT_EQ(loaded.document.at("nodes").at(1).at("translation"), json::array({0.0, 0.0, 2.0}));
  const json q = loaded.document.at("nodes").at(0).at("rotation");
  const Matrix3 R = rotation_from_quaternion(q[3], q[0], q[1], q[2]);
  EXPECT_LT(norm(rotate(R, {0, 0, 1}) - Vector3(0, 1, 0)), 1e-15);
  write_gltf(file.path(), recording, std::array{two_solids("object 0")}, {.is_z_up = false});
  EXPECT_FALSE(Loaded(file.path()).document.at("nodes").at(0).contains("rotation"));
}

TEST(Gltf, FramesCloserThanFloatsAreLeftOut) {
  const TemporaryFile file("close.gltf");
  Recording recording = make_recording(4, 1);
  recording.frames[2].time = recording.frames[1].time + 1e-12;
  write_gltf(file.path(), recording, std::array{two_solids("object 0")});
  const Loaded loaded(file.path());
  const auto times = loaded.floats(loaded.sampler(1, "rotation")->at("input"), "SCALAR");
  EXPECT_EQ(times.size(), 3u);
}

TEST(Gltf, RefusesWhatItCannotWrite) {
  const auto message = [](const Recording& recording, const std::string& path, const std::string& name) {
    return refusal_of([&] { write_gltf(path, recording, std::array{two_solids(name)}); });
  };
  const TemporaryFile file("refused.gltf");
  EXPECT_THAT(message({}, file.path(), "object 0"), HasSubstr("no frame"));
  EXPECT_THAT(message(make_recording(2, 1), file.path(), "other"), HasSubstr("'object 0'"));
  Recording falls = make_recording(3, 1);
  falls.frames[2].time = 0.0;
  EXPECT_THAT(message(falls, file.path(), "object 0"), HasSubstr("frame 2"));
  EXPECT_THAT(message(make_recording(2, 1), "/no/such/run.gltf", "object 0"), HasSubstr("/no/such/run.gltf"));
}

}  // namespace
}  // namespace touchstone
