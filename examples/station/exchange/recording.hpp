#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <variant>
#include <vector>

#include "touchstone/examples/station/exchange/exchange.hpp"
#include "touchstone/examples/station/flight/session.hpp"

namespace touchstone::station {

/// In force from a frame on: before frame `frame` was flown, counted from 0.
struct RecordedInput {
  std::uint64_t frame = 0;
  std::variant<HandInput, Control> input;
};

/// A recording is lines of JSON: a header {"station": 1, "scene": NAME, "rate_hz": R, "methods": BITS,
/// "dynamics": BOOL, "script": FILE, "files": HEX, "rates": {NAME: RATES}}, inputs as they came into force,
/// and {"frames": N, "hash": HEX} at the end, if it was ended.
struct Recording {
  std::string scene;
  double rate = 50.0;
  std::uint32_t methods = kAllMethods;
  std::vector<RecordedInput> inputs;
  std::uint64_t frames = 0;  ///< 0: not given
  std::string hash;          ///< empty: not given
  bool dynamics = false;
  std::string script = {}, files = {};  ///< of the scene: its file, and StationScene::files; empty: not given
  /// Of scenes whose hands are not HandScales{}. Recordings of before there were others have none.
  SceneScales rates = {};
};

std::string header_line(const Recording& recording);
std::string input_line(const RecordedInput& input, const StationScenes& scenes);
std::string end_line(std::uint64_t frames, std::uint64_t hash);
std::string hash_text(std::uint64_t hash);

/// @throws InputError, `name:line: reason`: a line that is none of these, frames out of order, a scene that
/// is not there.
Recording read_recording(std::istream& in, const std::string& name, const StationScenes& scenes);
/// Reads a recording's header alone. @throws InputError
Recording read_header(std::istream& in, const std::string& name);

/// Flies a recording without a clock. @param frames 0: as many as it names, or up to its last input.
/// @param each after every frame; may be empty.
void replay(const Recording& recording, Session& session, std::uint64_t frames = 0,
            const std::function<void(const Session&)>& each = {});

/// Takes inputs from the loop, and writes them on another thread. What finds no room is counted: the
/// recording is incomplete then, and its end states it.
class Recorder {
 public:
  /// Keeps a reference; in memory alone, until open(). The header gets the scenes' rates.
  Recorder(const StationScenes& scenes, Recording header);
  ~Recorder();
  /// Before the first input. @throws InputError: it is there and not empty, or cannot be written.
  void open(const std::filesystem::path& file);

  /// The loop's thread; no allocation.
  void offer(const RecordedInput& input) noexcept;
  /// The other thread: writes what is there. Returns whether there was any.
  bool work();
  /// After the loop has ended.
  void end(std::uint64_t frames, std::uint64_t hash);
  /// Any thread. The first kMostKept bytes.
  std::string kept() const;
  std::uint64_t lost() const { return lost_.load(std::memory_order_relaxed); }

  static constexpr std::size_t kMostKept = std::size_t{64} << 20U;

 private:
  void write(const std::string& line);

  struct State;
  const StationScenes* scenes_;
  Ring<RecordedInput> ring_;
  std::atomic<std::uint64_t> lost_{0};
  std::unique_ptr<State> state_;
};

}  // namespace touchstone::station
