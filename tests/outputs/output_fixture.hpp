#pragma once

#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "touchstone/contact_core/output/frame_output.hpp"
#include "touchstone/tests/support/random_poses.hpp"
#include "touchstone/tests/world/world_fixture.hpp"

namespace touchstone {

/// A file that is there for one test only.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& name)
      : path_(std::filesystem::temp_directory_path() / (std::to_string(getpid()) + "_" + name)) {}
  ~TemporaryFile() { std::filesystem::remove(path_); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  std::string path() const { return path_.string(); }
  std::string text() const {
    std::ifstream in(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void write(const std::string& text) const { std::ofstream(path_, std::ios::binary) << text; }

 private:
  std::filesystem::path path_;
};

/// Of an event that has none to tell.
inline PairGeometry zero_geometry() { return {0.0, Vector3::Zero(), Vector3::Zero(), Vector3::Zero(), 0}; }

/// Objects named "object 0" and so on.
inline void announce(FrameOutput& output, std::uint32_t objects) {
  for (std::uint32_t i = 0; i < objects; ++i) output.add_object({{i, 0}, "object " + std::to_string(i)});
}

inline void expect_adds_up(const OutputStatus& status) {
  EXPECT_EQ(status.offered, status.delivered + status.dropped);
}

/// Random frames, kept by value.
struct MadeFrame {
  std::uint64_t frame;
  double time;
  std::vector<ShownPose> poses;
  std::vector<ContactEvent> events;

  OutputFrame view() const { return {frame, time, poses, events}; }
};

inline std::vector<MadeFrame> make_frames(std::size_t count, std::uint32_t objects, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<MadeFrame> frames;
  for (std::size_t k = 0; k < count; ++k) {
    MadeFrame made{k, static_cast<double>(k) / 30.0, {}, {}};
    for (std::uint32_t i = 0; i < objects; ++i) made.poses.push_back({{i, 0}, random_pose(random, 10.0)});
    for (std::uint32_t i = 0; i < k % 3; ++i) {
      const Vector3 n = random_vector(random, 1.0);
      const Vector3 p_A = random_vector(random, 1e3);
      const Vector3 p_B = random_vector(random, 1e-9);
      const Vector3 end = random_vector(random, 1e3);
      made.events.push_back({static_cast<EventKind>(k % 6),
                             {i, 0},
                             {i + 1, 0},
                             {i, 3},
                             uniform(random, 0, 1),
                             {uniform(random, -1, 1), n, p_A, p_B, 0},
                             i + 7,
                             {uniform(random, -1, 1), -n, end, p_A, 0}});
    }
    frames.push_back(std::move(made));
  }
  return frames;
}

template <class Vector>
bool same_bits(const Vector& a, const Vector& b) {
  return std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

inline bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }
inline bool same_bits(const PairGeometry& a, const PairGeometry& b) {
  return same_bits(a.separation, b.separation) && same_bits(a.n_AB_W, b.n_AB_W) &&
         same_bits(a.p_A_W, b.p_A_W) && same_bits(a.p_B_W, b.p_B_W);
}
inline bool same_bits(const Pose& a, const Pose& b) { return same_bits(a.R, b.R) && same_bits(a.p, b.p); }

}  // namespace touchstone
