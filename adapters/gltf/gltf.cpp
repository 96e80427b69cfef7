#include "touchstone/adapters/gltf/gltf.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>

#include "touchstone/adapters/gltf/gltf_buffer.hpp"
#include "touchstone/adapters/gltf/gltf_mesh.hpp"
#include "touchstone/contact_core/geometry/quaternion.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

using gltf::Buffer;
using nlohmann::ordered_json;

/// A node's motion over the frames that are kept.
struct Track {
  std::vector<float> translations, rotations, scales;
  bool moves = false;  ///< more than one pose
  bool comes_or_goes = false;
};

/// Frames whose times rise as floats, from 0.
struct Keys {
  std::vector<std::size_t> frames;
  std::vector<float> times;
};

Keys keys_of(const Recording& recording) {
  if (recording.frames.empty()) throw InputError("gltf: the recording has no frame");
  Keys keys;
  const double start = recording.frames.front().time;
  double last = start;
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    const double time = recording.frames[i].time;
    if (!(time >= last)) {
      throw InputError("gltf: the time falls at frame " + std::to_string(recording.frames[i].frame) + ": " +
                       std::to_string(time) + " s");
    }
    last = time;
    const auto key = static_cast<float>(time - start);
    if (!keys.times.empty() && !(key > keys.times.back())) continue;
    keys.frames.push_back(i);
    keys.times.push_back(key);
  }
  return keys;
}

/// The pose of `object` in each key's frame; none where it is missing.
std::vector<const Pose*> poses_of(const Recording& recording, const Keys& keys, std::uint32_t object) {
  std::vector<const Pose*> poses;
  for (const std::size_t frame : keys.frames) {
    const std::vector<RecordedPose>& shown = recording.frames[frame].poses;
    const auto found =
        std::find_if(shown.begin(), shown.end(), [&](const RecordedPose& p) { return p.object == object; });
    poses.push_back(found == shown.end() ? nullptr : &found->X_WO);
  }
  return poses;
}

/// Where it is missing it stays where it was last, or will be first, at size 0.
std::optional<Track> track_of(const std::vector<const Pose*>& poses) {
  const auto first =
      std::find_if(poses.begin(), poses.end(), [](const Pose* pose) { return pose != nullptr; });
  if (first == poses.end()) return std::nullopt;
  Track track;
  const Pose* pose = *first;
  Quaternion last = quaternion_of(pose->R);
  for (const Pose* shown : poses) {
    track.comes_or_goes |= shown == nullptr;
    if (shown != nullptr) {
      track.moves |= shown->p != pose->p || shown->R != pose->R;
      pose = shown;
    }
    Quaternion q = quaternion_of(pose->R);
    // q and -q turn alike; the nearer one lets viewers take the shorter arc.
    if (q.w * last.w + dot(q.v, last.v) < 0.0) q = {-q.w, -q.v};
    last = q;
    for (int i = 0; i < 3; ++i) track.translations.push_back(static_cast<float>(pose->p(i)));
    for (const double component : {q.v.x(), q.v.y(), q.v.z(), q.w})
      track.rotations.push_back(static_cast<float>(component));
    track.scales.insert(track.scales.end(), 3, shown != nullptr ? 1.0F : 0.0F);
  }
  return track;
}

/// A glTF document as it grows.
class Document {
 public:
  explicit Document(const GltfOptions& options) {
    document_["asset"] = {{"version", "2.0"}, {"generator", "touchstone"}};
    document_["scene"] = 0;
    document_["scenes"] = {{{"nodes", {0}}}};
    ordered_json world{{"name", "world"}};
    if (options.is_z_up) world["rotation"] = {-std::sqrt(0.5), 0.0, 0.0, std::sqrt(0.5)};
    nodes_.push_back(std::move(world));
  }

  void add(const HexahedronTree& tree, const Track& track, std::span<const float> times) {
    const gltf::Mesh mesh = gltf::make_mesh(tree);
    const std::size_t positions = buffer_.add(mesh.positions, "VEC3", Buffer::Target::vertices);
    const std::size_t indices = buffer_.add(mesh.indices);
    const ordered_json primitive{{"attributes", {{"POSITION", positions}}}, {"indices", indices}};
    meshes_.push_back({{"name", tree.name()}, {"primitives", ordered_json::array({primitive})}});
    const auto first = [](const std::vector<float>& values, std::size_t count) {
      return std::vector<float>(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(count));
    };
    nodes_.push_back({{"name", tree.name()},
                      {"mesh", meshes_.size() - 1},
                      {"translation", first(track.translations, 3)},
                      {"rotation", first(track.rotations, 4)},
                      {"scale", first(track.scales, 3)}});
    if (track.moves) {
      add_channel("translation", track.translations, "VEC3", "LINEAR", times);
      add_channel("rotation", track.rotations, "VEC4", "LINEAR", times);
    }
    if (track.comes_or_goes) add_channel("scale", track.scales, "VEC3", "STEP", times);
  }

  std::string text() {
    std::vector<std::size_t> children;
    for (std::size_t i = 1; i < nodes_.size(); ++i) children.push_back(i);
    if (!children.empty()) nodes_[0]["children"] = children;
    document_["nodes"] = nodes_;
    if (!meshes_.empty()) {
      document_["meshes"] = meshes_;
      buffer_.write(document_);
    }
    if (!channels_.empty()) {
      const ordered_json animation{{"name", "run"}, {"channels", channels_}, {"samplers", samplers_}};
      document_["animations"] = ordered_json::array({animation});
    }
    return document_.dump();
  }

 private:
  /// For the last node.
  void add_channel(const char* path, std::span<const float> values, const char* type,
                   const char* interpolation, std::span<const float> times) {
    if (!times_) times_ = buffer_.add(times, "SCALAR");
    samplers_.push_back(
        {{"input", *times_}, {"interpolation", interpolation}, {"output", buffer_.add(values, type)}});
    channels_.push_back(
        {{"sampler", samplers_.size() - 1}, {"target", {{"node", nodes_.size() - 1}, {"path", path}}}});
  }

  ordered_json document_;
  ordered_json nodes_ = ordered_json::array(), meshes_ = ordered_json::array();
  ordered_json channels_ = ordered_json::array(), samplers_ = ordered_json::array();
  std::optional<std::size_t> times_;
  Buffer buffer_;
};

}  // namespace

void write_gltf(const std::string& path, const Recording& recording,
                std::span<const std::shared_ptr<const HexahedronTree>> trees, const GltfOptions& options) {
  const Keys keys = keys_of(recording);
  Document document(options);
  for (std::uint32_t i = 0; i < recording.objects.size(); ++i) {
    const std::optional<Track> track = track_of(poses_of(recording, keys, i));
    if (!track) continue;  // named by events only
    const std::string& name = recording.objects[i];
    const auto tree =
        std::find_if(trees.begin(), trees.end(), [&](const auto& t) { return t->name() == name; });
    if (tree == trees.end()) throw InputError("gltf: no hexahedra for the recorded object '" + name + "'");
    document.add(**tree, *track, keys.times);
  }
  std::ofstream file(path, std::ios::binary);
  file << document.text();
  if (!file.flush()) throw InputError("gltf: '" + path + "' cannot be written");
}

}  // namespace touchstone
