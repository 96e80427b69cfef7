#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "touchstone/contact_core/output/frame_output.hpp"
#include "touchstone/contact_core/output/recording.hpp"

namespace touchstone {

/// How Recorder::write() acts while the rows are full.
enum class WhenFull : std::uint8_t {
  drop,  ///< the frame is dropped whole and counted; the record states how many are missing, and where
  wait,  ///< write() waits for room: nothing is lost, but a slow disk delays frames
};

/// Memory of a Recorder, and its patience.
struct RecorderOptions {
  /// Memory between the frame loop and the writing thread: a frame takes one row, and one more for each pose
  /// and event; 168 bytes each. Rounded up to a power of two.
  std::size_t rows = std::size_t{1} << 16;
  WhenFull when_full = WhenFull::drop;
  /// How long close() waits for a receiver that takes nothing (a pipe that nobody reads).
  std::chrono::milliseconds patience{1000};
};

/// Writes a run as CSV, from a thread of its own. One line per row; the first names the columns, as in
/// README.md. Doubles are written so that they read back bit for bit (of a NaN: that it is one).
///
/// When the system refuses (as on a full disk), the frames concerned are cut off whole and counted, and the
/// next frames are tried again: a record holds whole frames only, and a line `lost` stands where some are
/// missing.
class Recorder final : public FrameOutput {
 public:
  /// Creates the file, or empties it. @throws InputError naming the path and the system's reason.
  explicit Recorder(const std::string& path, const RecorderOptions& options = {});
  /// Writes to an open file, pipe or socket, and closes it in the end; sets it to non-blocking.
  explicit Recorder(int descriptor, const RecorderOptions& options = {});
  ~Recorder() override;

  /// @throws InputError: a name of more than 2000 bytes, or more objects than a frame has rows for.
  void add_object(const OutputObject& object) override;
  void write(const OutputFrame& frame) noexcept override;
  OutputStatus status() const noexcept override;

  /// Waits until all that was taken is written and ends the record; frames that come later are dropped and
  /// counted. The destructor does it too.
  void close() noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Reads a record back. One that was cut off (a crash) gives its whole frames, not `is_complete`.
/// @throws InputError naming file and line: it cannot be read, is no record, or a line makes no sense.
Recording read_recording(const std::string& path);

}  // namespace touchstone
