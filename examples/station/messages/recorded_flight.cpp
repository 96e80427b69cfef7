#include "touchstone/examples/station/messages/recorded_flight.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "touchstone/adapters/scene_files/dynamics_file.hpp"
#include "touchstone/contact_core/geometry/quaternion.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/program/files/json.hpp"
#include "touchstone/examples/station/flight/solids_json.hpp"
#include "touchstone/examples/station/messages/frame_message.hpp"
#include "touchstone/examples/training_run/setting/setting.hpp"

#ifdef TOUCHSTONE_HAS_RECORDER
#include "touchstone/adapters/recorder/recorder.hpp"
#endif

namespace touchstone::station {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr std::size_t kMostSaved = std::size_t{1} << 30;  ///< bytes

// ---- the scene that was run

bool has_key(const fs::path& file, const std::string& key) {
  std::ifstream in(file);
  if (!in) throw InputError(file.string() + ": cannot be read");
  for (std::string line; std::getline(in, line);)
    if (line.rfind(key + ":", 0) == 0) return true;
  return false;
}

/// A script's objects and the links of its arms; a scene's, with those of its dynamics' arms.
std::vector<SceneObject> objects_of(const fs::path& file, const SceneRobots& robots) {
  if (is_robot_file(file) || has_key(file, "hands"))
    return training::Setting(SceneRobot().read_script(file, robots)).scene().objects;
  if (has_key(file, "dynamics"))
    return load_dynamic_scene(file, {}, robot_files::arm_models(robots.choices, robots.on_account))
        .scene.objects;
  return load_scene(file).objects;
}

std::vector<HexahedronTree> trees_of(const touchstone::Recording& recording, const fs::path& scene,
                                     const SceneRobots& robots) {
  const std::vector<SceneObject> objects = objects_of(scene, robots);
  std::vector<HexahedronTree> trees;
  for (const std::string& name : recording.objects) {
    const auto found = std::find_if(objects.begin(), objects.end(),
                                    [&](const SceneObject& each) { return each.tree.name() == name; });
    if (found == objects.end())
      throw InputError(scene.string() + ": has no object '" + name + "', which the record names");
    refuse_rounded(found->tree, "the station");
    trees.push_back(found->tree);
  }
  return trees;
}

/// Of frames that were read: what the page could not show. Their objects' indices are the reader's.
void check_frame(const RecordedFrame& frame, const RecordedFlight& flight, const fs::path& file) {
  const auto refuse = [&](const std::string& reason) {
    throw InputError(file.string() + ": frame " + std::to_string(frame.frame) + ": " + reason);
  };
  if (!std::isfinite(frame.time)) refuse("its time is no finite number");
  const auto has_solid = [&](std::uint32_t object, SolidIndex solid) {
    return solid < flight.trees[object].solids().size();
  };
  for (const RecordedPose& pose : frame.poses)
    if (!is_finite(pose.X_WO))
      refuse("the pose of '" + flight.recording.objects[pose.object] + "' is not finite");
  for (const RecordedEvent& event : frame.events)
    if (event.b != RecordedEvent::kNone &&
        (!has_solid(event.a, event.solids.a) || !has_solid(event.b, event.solids.b)))
      refuse("an event names a solid that the scene lacks");
}

// ---- series of dynamics_run

/// The fields of a line (RFC 4180, without line breaks in fields).
std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> out(1);
  bool is_quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const bool is_quote = line[i] == '"';
    if (is_quote && is_quoted && i + 1 < line.size() && line[i + 1] == '"')
      out.back() += line[++i];
    else if (is_quote)
      is_quoted = !is_quoted;
    else if (line[i] == ',' && !is_quoted)
      out.emplace_back();
    else
      out.back() += line[i];
  }
  return out;
}

/// Columns of an object: x, y, z of its position, w, x, y, z of its attitude.
using PoseColumns = std::array<std::size_t, 7>;

std::vector<PoseColumns> find_columns(const std::vector<std::string>& head, touchstone::Recording& out) {
  constexpr const char* kFirst = ".position_x_m";
  const auto column = [&](const std::string& name) {
    const auto found = std::find(head.begin(), head.end(), name);
    if (found == head.end()) throw InputError("no column '" + name + "'");
    return static_cast<std::size_t>(found - head.begin());
  };
  std::vector<PoseColumns> columns;
  for (const std::string& name : head) {
    const std::size_t end = name.size() - std::min(name.size(), std::string(kFirst).size());
    if (name.substr(end) != kFirst) continue;
    const std::string object = name.substr(0, end);
    out.objects.push_back(object);
    PoseColumns& each = columns.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) each[i] = column(object + ".position_" + "xyz"[i] + "_m");
    for (std::size_t i = 0; i < 4; ++i) each[3 + i] = column(object + ".attitude_" + "wxyz"[i]);
  }
  if (columns.empty()) throw InputError("no object's position");
  return columns;
}

double number_of(const std::string& text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    throw InputError("'" + text + "' is no number");
  return value;
}

RecordedFrame frame_of(const std::vector<std::string>& fields, const std::vector<PoseColumns>& columns,
                       std::size_t width, std::uint64_t number) {
  if (fields.size() != width) throw InputError("another number of fields than columns");
  RecordedFrame frame;
  frame.frame = number;
  frame.time = number_of(fields[0]);
  for (std::uint32_t object = 0; object < columns.size(); ++object) {
    std::array<double, 7> x;
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = number_of(fields[columns[object][i]]);
    if (x[3] * x[3] + x[4] * x[4] + x[5] * x[5] + x[6] * x[6] == 0.0) throw InputError("no attitude");
    Pose X;
    X.p = {x[0], x[1], x[2]};
    X.R = rotation_matrix(normalized({x[3], {x[4], x[5], x[6]}}));
    frame.poses.push_back({object, X});
  }
  return frame;
}

touchstone::Recording read_series(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  std::size_t number = 1;
  try {
    std::getline(in, line);
    const std::vector<std::string> head = fields_of(line);
    touchstone::Recording out;
    const std::vector<PoseColumns> columns = find_columns(head, out);
    for (++number; std::getline(in, line); ++number)
      out.frames.push_back(frame_of(fields_of(line), columns, head.size(), number - 2));
    out.is_complete = true;
    return out;
  } catch (const InputError& error) {
    throw InputError(file.string() + ":" + std::to_string(number) + ": " + error.what());
  }
}

bool is_series(const fs::path& file) {
  std::ifstream in(file);
  if (!in) throw InputError(file.string() + ": cannot be read");
  std::string line;
  std::getline(in, line);
  return line.rfind("time_s,", 0) == 0;
}

touchstone::Recording read_any(const fs::path& file) {
  if (is_series(file)) return read_series(file);
#ifdef TOUCHSTONE_HAS_RECORDER
  return read_recording(file.string());
#else
  throw InputError(file.string() + ": this build lacks the adapter RECORDER (TOUCHSTONE_WITH_RECORDER)");
#endif
}

// ---- as the page has it

std::vector<SolidIndex> first_solids_of(const RecordedFlight& flight) {
  std::vector<SolidIndex> out;
  SolidIndex next = 0;
  for (const HexahedronTree& tree : flight.trees) {
    out.push_back(next);
    next += static_cast<SolidIndex>(tree.solids().size());
  }
  return out;
}

/// Where all stand in a frame; what is missing from it stands where it was last.
void take_poses(const RecordedFrame& frame, std::vector<Pose>& poses) {
  for (const RecordedPose& pose : frame.poses) poses[pose.object] = pose.X_WO;
}

/// The way of each object's origin over the record [m].
std::vector<double> ways_of(const touchstone::Recording& recording) {
  std::vector<double> ways(recording.objects.size(), 0.0);
  std::vector<Pose> before(ways.size()), now(ways.size());
  if (!recording.frames.empty()) take_poses(recording.frames[0], now);
  for (const RecordedFrame& frame : recording.frames) {
    before = now;
    take_poses(frame, now);
    for (std::size_t i = 0; i < ways.size(); ++i) ways[i] += norm(now[i].p - before[i].p);
  }
  return ways;
}

json objects_json(const RecordedFlight& flight, const std::vector<double>& ways) {
  json out = json::array();
  const std::vector<SolidIndex> first = first_solids_of(flight);
  for (std::size_t i = 0; i < flight.trees.size(); ++i) {
    json solids = json::array();
    for (SolidIndex k = 0; k < flight.trees[i].solids().size(); ++k) solids.push_back(first[i] + k);
    out.push_back({{"name", flight.recording.objects[i]},
                   {"kind", ways[i] > 0.0 ? "free" : "static"},
                   {"selectable", true},
                   {"moves", ways[i] > 0.0},
                   {"solids", solids}});
  }
  return out;
}

json solids_json(const RecordedFlight& flight) {
  json out = json::array();
  for (std::uint32_t i = 0; i < flight.trees.size(); ++i) append_solids(flight.trees[i], i, out);
  return out;
}

std::string texts_of(const RecordedFlight& flight) {
  const std::vector<double> ways = ways_of(flight.recording);
  const auto farthest = std::max_element(ways.begin(), ways.end()) - ways.begin();
  const json tip = {{"name", "what moved farthest"},
                    {"object", farthest},
                    {"position", {0.0, 0.0, 0.0}},
                    {"rotation", {0.0, 0.0, 0.0, 1.0}},
                    {"jaws", json::array()}};
  const json scene = {{"type", "scene"},
                      {"name", flight.name},
                      {"title", flight.name},
                      {"description", "a record"},
                      {"objects", objects_json(flight, ways)},
                      {"solids", solids_json(flight)},
                      {"arms", json::array()},
                      {"tips", json::array({tip})},
                      {"cameras", json::array()},
                      {"latches", json::array()},
                      {"tasks", json::array()}};
  const json method = {{"name", "recorded"}, {"what", "as another program flew it"}};
  const json hello = {{"methods", json::array({method})}};
  return program::one_line(json{{"hello", hello}, {"scene", scene}});
}

void append_size(std::size_t size, std::string& out) {
  const auto bytes = static_cast<std::uint32_t>(size);
  for (int i = 0; i < 4; ++i) out += static_cast<char>(bytes >> (8 * i) & 0xffU);
}

}  // namespace

RecordedFlight load_recorded_flight(const fs::path& record, const fs::path& scene,
                                    const SceneRobots& robots) {
  RecordedFlight out;
  out.name = record.stem().string();
  out.recording = read_any(record);
  if (out.recording.frames.empty() || out.recording.objects.empty())
    throw InputError(record.string() + ": has no frame with an object");
  out.trees = trees_of(out.recording, scene, robots);
  for (const RecordedFrame& frame : out.recording.frames) check_frame(frame, out, record);
  return out;
}

std::string saved_flight(const RecordedFlight& flight) {
  const std::string texts = texts_of(flight);
  std::string out = "TSR1";
  append_size(texts.size(), out);
  out += texts;
  const std::vector<SolidIndex> first = first_solids_of(flight);
  std::vector<Pose> poses(flight.trees.size());
  std::vector<std::uint8_t> bytes;
  for (const RecordedFrame& frame : flight.recording.frames) {
    take_poses(frame, poses);
    write_recorded_frame(frame, poses, first, bytes);
    append_size(bytes.size(), out);
    out.append(bytes.begin(), bytes.end());
    if (out.size() > kMostSaved)
      throw InputError("the record '" + flight.name + "' has more frames than a page holds (1 GiB)");
  }
  return out;
}

}  // namespace touchstone::station
