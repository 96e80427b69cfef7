#include "touchstone/examples/station/exchange/recording.hpp"

#include <fmt/format.h>

#include <fstream>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>

#include "touchstone/adapters/plugin/utf8.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/program/files/json.hpp"
#include "touchstone/examples/station/flight/bytes.hpp"

namespace touchstone::station {
namespace {

using nlohmann::json;

constexpr std::size_t kRoom = 4096;
constexpr std::array<const char*, 16> kControlNames = {
    "frame_of_command", "vernier", "brakes", "joint_mode",  "latch",       "release",  "reset",       "scene",
    "select",           "methods", "policy", "joint_brake", "late_report", "dynamics", "torque_loss", "tip"};

json numbers(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

Vector3 vector_of(const json& values) {
  const auto v = values.get<std::array<double, 3>>();
  return {v[0], v[1], v[2]};
}

Control::Kind kind_of(const std::string& name) {
  for (std::size_t i = 0; i < kControlNames.size(); ++i)
    if (name == kControlNames[i]) return static_cast<Control::Kind>(i);
  throw InputError("unknown control '" + name + "'");
}

Control control_of(const json& line, const StationScenes& scenes) {
  Control control;
  control.kind = kind_of(line.at("control"));
  control.on = line.at("on");
  control.index = line.at("index");
  control.value = line.at("value");
  control.attitude = line.at("attitude");
  if (control.kind != Control::Kind::scene) return control;
  const std::string name = line.at("scene");
  control.index = static_cast<std::uint32_t>(find_scene(scenes, name));
  if (control.index == scenes.size()) throw InputError("there is no scene '" + name + "'");
  return control;
}

void read_line(const json& line, const StationScenes& scenes, Recording& out) {
  if (!out.hash.empty()) throw InputError("there is more after its end");
  if (line.contains("frames")) {
    out.frames = line.at("frames");
    out.hash = line.at("hash");
    return;
  }
  RecordedInput input;
  input.frame = line.at("frame");
  if (!out.inputs.empty() && input.frame < out.inputs.back().frame) throw InputError("frames out of order");
  if (line.contains("control"))
    input.input = control_of(line, scenes);
  else
    input.input = HandInput{vector_of(line.at("translation")), vector_of(line.at("rotation")),
                            line.at("joint"), line.value("grip", 0.0)};
  out.inputs.push_back(input);
}

}  // namespace

std::string hash_text(std::uint64_t hash) { return fmt::format("{:016x}", hash); }

std::string header_line(const Recording& recording) {
  json line = {{"station", 1},
               {"scene", recording.scene},
               {"rate_hz", recording.rate},
               {"methods", recording.methods},
               {"dynamics", recording.dynamics},
               {"script", recording.script},
               {"files", recording.files}};
  line["rates"] = json::object();
  for (const auto& [name, scales] : recording.rates) line["rates"][name] = rates_json(scales);
  // Bytes that are no UTF-8 are replaced in a text, so that the file would not be found again.
  if (!is_utf8(recording.script)) line["script_hex"] = hex_of(recording.script);
  return program::one_line(line) + "\n";
}

std::string input_line(const RecordedInput& input, const StationScenes& scenes) {
  json line = {{"frame", input.frame}};
  if (const auto* hand = std::get_if<HandInput>(&input.input)) {
    line["translation"] = numbers(hand->translation);
    line["rotation"] = numbers(hand->rotation);
    line["joint"] = hand->joint;
    line["grip"] = hand->grip;
  } else {
    const auto& control = std::get<Control>(input.input);
    line["control"] = kControlNames.at(static_cast<std::size_t>(control.kind));
    line["on"] = control.on;
    line["index"] = control.index;
    line["value"] = control.value;
    line["attitude"] = control.attitude;
    if (control.kind == Control::Kind::scene) line["scene"] = scenes.at(control.index)->name;
  }
  return program::one_line(line) + "\n";
}

std::string end_line(std::uint64_t frames, std::uint64_t hash) {
  return program::one_line(json{{"frames", frames}, {"hash", hash_text(hash)}}) + "\n";
}

Recording read_header(std::istream& in, const std::string& name) {
  std::string text;
  std::getline(in, text);
  const json line = json::parse(text, nullptr, false);
  if (!line.is_object() || !line.contains("station") || line.at("station") != 1)
    throw InputError(name + ":1: no recording of the station");
  try {
    Recording out;
    out.scene = line.at("scene");
    out.rate = line.at("rate_hz");
    out.methods = line.at("methods");
    out.dynamics = line.value("dynamics", false);
    out.script = line.contains("script_hex") ? bytes_of(line.at("script_hex").get<std::string>())
                                             : line.value("script", "");
    out.files = line.value("files", "");
    const json rates = line.value("rates", json::object());
    for (const auto& [scene, scales] : rates.items()) out.rates[scene] = scales_of(scales);
    return out;
  } catch (const json::exception& error) {
    throw InputError(name + ":1: " + error.what());
  } catch (const InputError& error) {
    throw InputError(name + ":1: " + error.what());
  }
}

Recording read_recording(std::istream& in, const std::string& name, const StationScenes& scenes) {
  Recording out = read_header(in, name);
  std::string text;
  for (std::size_t number = 2; std::getline(in, text); ++number) {
    const std::string where = name + ":" + std::to_string(number) + ": ";
    try {
      read_line(json::parse(text), scenes, out);
    } catch (const json::exception& error) {
      throw InputError(where + error.what());
    } catch (const InputError& error) {
      throw InputError(where + error.what());
    }
  }
  return out;
}

namespace {

/// As the loop: what a control throws is its answer.
void set_as_flown(Session& session, const Control& control) {
  try {
    session.set(control);
  } catch (const std::exception&) {
  }
}

}  // namespace

void replay(const Recording& recording, Session& session, std::uint64_t frames,
            const std::function<void(const Session&)>& each) {
  if (frames == 0) frames = recording.frames;
  if (frames == 0 && !recording.inputs.empty()) frames = recording.inputs.back().frame + 1;
  HandInput hand;
  auto next = recording.inputs.begin();
  while (session.frame() < frames) {
    for (; next != recording.inputs.end() && next->frame <= session.frame(); ++next) {
      if (const auto* input = std::get_if<HandInput>(&next->input))
        hand = *input;
      else
        set_as_flown(session, std::get<Control>(next->input));
    }
    session.step(hand);
    if (each) each(session);
  }
}

struct Recorder::State {
  mutable std::mutex mutex;
  std::string kept;
  std::ofstream file;
};

Recorder::Recorder(const StationScenes& scenes, Recording header)
    : scenes_(&scenes), ring_(kRoom), state_(std::make_unique<State>()) {
  for (const auto& scene : scenes)
    if (!(scene->scales == HandScales{})) header.rates[scene->name] = scene->scales;
  write(header_line(header));
}

void Recorder::open(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::is_regular_file(file, error) && std::filesystem::file_size(file, error) != 0)
    throw InputError(file.string() + ": is there already, and is not overwritten");
  state_->file.open(file, std::ios::app);
  state_->file << kept() << std::flush;
  if (!state_->file) throw InputError(file.string() + ": cannot be written");
}

Recorder::~Recorder() = default;

void Recorder::offer(const RecordedInput& input) noexcept {
  if (!ring_.push(input)) lost_.fetch_add(1, std::memory_order_relaxed);
}

void Recorder::write(const std::string& line) {
  if (state_->file.is_open() && !(state_->file << line << std::flush))
    lost_.fetch_add(1, std::memory_order_relaxed);  // a full disk
  const std::lock_guard lock(state_->mutex);
  if (state_->kept.size() + line.size() <= kMostKept) state_->kept += line;
}

bool Recorder::work() {
  bool any = false;
  while (const RecordedInput* input = ring_.front()) {
    write(input_line(*input, *scenes_));
    ring_.pop();
    any = true;
  }
  return any;
}

void Recorder::end(std::uint64_t frames, std::uint64_t hash) {
  work();
  if (lost() == 0) write(end_line(frames, hash));
}

std::string Recorder::kept() const {
  const std::lock_guard lock(state_->mutex);
  return state_->kept;
}

}  // namespace touchstone::station
