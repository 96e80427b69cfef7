#include "touchstone/examples/training_run/results/outputs.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/program/files/report_files.hpp"

#ifdef TOUCHSTONE_HAS_RECORDER
#include "touchstone/adapters/recorder/recorder.hpp"
#endif
#ifdef TOUCHSTONE_HAS_CIGI
#include "touchstone/adapters/cigi/cigi_output.hpp"
#endif
#ifdef TOUCHSTONE_HAS_GLTF
#include "touchstone/adapters/gltf/gltf.hpp"
#endif

namespace touchstone::training {
namespace {

namespace fs = std::filesystem;

#ifdef TOUCHSTONE_HAS_RECORDER
constexpr bool kHasRecorder = true;
#else
constexpr bool kHasRecorder = false;
#endif
#ifdef TOUCHSTONE_HAS_CIGI
constexpr bool kHasCigi = true;
#else
constexpr bool kHasCigi = false;
#endif
#ifdef TOUCHSTONE_HAS_GLTF
constexpr bool kHasGltf = true;
#else
constexpr bool kHasGltf = false;
#endif

std::string lacks(const char* adapter) {
  return std::string("this build lacks the adapter ") + adapter + " (TOUCHSTONE_WITH_" + adapter + ")";
}

struct Address {
  std::string host;
  std::uint16_t port = 0;
};

Address address_from(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  Address address;
  if (colon != std::string::npos && colon > 0) {
    address.host = text.substr(0, colon);
    const char* const end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data() + colon + 1, end, address.port);
    if (error == std::errc() && rest == end && address.port != 0) return address;
  }
  throw InputError("--cigi " + text + ": is no HOST:PORT");
}

void make_folder(const std::string& option, const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw InputError(option + " " + folder + ": " + error.message());
}

std::vector<std::string> with_extension(std::vector<std::string> names, const char* extension) {
  for (std::string& name : names) name += extension;
  return names;
}

#ifdef TOUCHSTONE_HAS_RECORDER
/// A flight is faster than its clock: room for all of its frames, and for two events a pair and frame.
/// 168 bytes each, at most 88 MB; what finds no room is counted.
RecorderOptions recorder_options(const Setting& setting, std::chrono::milliseconds patience) {
  constexpr std::size_t kMostRows = std::size_t{1} << 19;
  const std::size_t frames = setting.frame_count() + 1;
  RecorderOptions options;
  options.patience = patience;
  options.rows = std::min(kMostRows, frames * (1 + setting.object_count() + 4 * setting.pairs().size()));
  return options;
}
#endif

}  // namespace

void prepare_outputs(const OutputOptions& options, const std::vector<std::string>& flights) {
  const std::string& record = options.records_option;
  if (!options.records.empty()) {
    if (!kHasRecorder) throw InputError(record + ": " + lacks("RECORDER"));
    make_folder(record, options.records);
    program::StreamedFile::check(record, options.records, with_extension(flights, ".csv"));
  }
  if (!options.animations.empty()) {
    if (!kHasGltf) throw InputError("--gltf: " + lacks("GLTF"));
    if (options.records.empty()) throw InputError("--gltf: is written from records; give " + record + " too");
    make_folder("--gltf", options.animations);
    program::StreamedFile::check("--gltf", options.animations, with_extension(flights, ".gltf"));
  }
  if (!options.cigi.empty()) {
    if (!kHasCigi) throw InputError("--cigi: " + lacks("CIGI"));
    address_from(options.cigi);
  }
}

std::string outputs_text() {
  const auto line = [](const char* option, bool is_here, const char* adapter, const char* what) {
    return std::string("  ") + option + "  " + (is_here ? what : lacks(adapter)) + "\n";
  };
  return line("--record", kHasRecorder, "RECORDER", "records, CSV") +
         line("--gltf  ", kHasGltf, "GLTF", "animations, glTF 2.0") +
         line("--cigi  ", kHasCigi, "CIGI", "an image generator, CIGI 3.3 over UDP");
}

struct FlightOutputs::State {
  const Setting* setting;
  std::optional<program::StreamedFile> record_file;
  std::string record;                            // a copy of its path, as it stays; empty: none
  std::string animation_folder, animation_name;  // empty: none
  bool is_shown = false, has_ended = false;
  std::vector<std::string> names;
  std::vector<std::unique_ptr<FrameOutput>> outputs;
  std::vector<FrameOutput*> receivers;

  void add(std::string name, std::unique_ptr<FrameOutput> output) {
    receivers.push_back(output.get());
    outputs.push_back(std::move(output));
    names.push_back(std::move(name));
  }

  /// The outputs that could not be written; empty: none.
  std::string write_animation() const {
    program::StreamedFile animation(animation_folder, animation_name);
#if defined(TOUCHSTONE_HAS_GLTF) && defined(TOUCHSTONE_HAS_RECORDER)
    std::vector<std::shared_ptr<const HexahedronTree>> trees;
    for (const SceneObject& object : setting->scene().objects)
      trees.emplace_back(std::shared_ptr<void>(), &object.tree);  // the setting's
    try {
      write_gltf(animation.path().string(), read_recording(record), trees);
      return animation.keep();
    } catch (const InputError& error) {
      return error.what();
    }
#endif
    return "";
  }
};

FlightOutputs::FlightOutputs(const OutputOptions& options, const Setting& setting, const std::string& name,
                             bool is_shown)
    : state_(std::make_unique<State>()) {
  state_->setting = &setting;
#ifdef TOUCHSTONE_HAS_RECORDER
  // Each flight has a record of its own.
  if (!options.records.empty()) {
    state_->record = (fs::path(options.records) / (name + ".csv")).string();
    state_->record_file.emplace(options.records, name + ".csv");
    state_->add("record", std::make_unique<Recorder>(state_->record_file->path().string(),
                                                     recorder_options(setting, options.patience)));
  }
#endif
  // An animation is written when the flight is over.
  if (!options.animations.empty()) {
    state_->animation_folder = options.animations;
    state_->animation_name = name + ".gltf";
  }
#ifdef TOUCHSTONE_HAS_CIGI
  // The image generator shows one flight in real time.
  if (is_shown && !options.cigi.empty()) {
    const Address address = address_from(options.cigi);
    CigiOptions cigi_options;
    cigi_options.host = address.host;
    cigi_options.port = address.port;
    cigi_options.anchor = cigi::AttachedTo{0, cigi::z_up()};
    state_->add("cigi " + options.cigi, std::make_unique<CigiOutput>(cigi_options));
    state_->is_shown = true;
  }
#else
  static_cast<void>(is_shown);
#endif
}

FlightOutputs::~FlightOutputs() = default;

std::span<FrameOutput* const> FlightOutputs::receivers() const { return state_->receivers; }
bool FlightOutputs::is_in_real_time() const { return state_->is_shown; }

std::vector<OutputFigures> FlightOutputs::end() {
  State& s = *state_;
  std::vector<OutputFigures> figures;
  if (s.has_ended) return figures;
  s.has_ended = true;
  for (std::size_t i = 0; i < s.outputs.size(); ++i) {
#ifdef TOUCHSTONE_HAS_RECORDER
    if (auto* recorder = dynamic_cast<Recorder*>(s.outputs[i].get())) recorder->close();
#endif
    figures.push_back({s.names[i], s.outputs[i]->status(), ""});
  }
  if (s.record_file) figures.front().error = s.record_file->keep();
  return figures;
}

std::vector<OutputFigures> FlightOutputs::write_animation() {
  std::vector<OutputFigures> figures;
  if (!state_->animation_name.empty()) figures.push_back({"gltf", {}, state_->write_animation()});
  return figures;
}

std::vector<OutputFigures> FlightOutputs::close() {
  std::vector<OutputFigures> figures = end();
  for (OutputFigures& animation : write_animation()) figures.push_back(std::move(animation));
  return figures;
}

}  // namespace touchstone::training
