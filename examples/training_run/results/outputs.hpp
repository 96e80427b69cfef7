#pragma once

#include <chrono>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "touchstone/contact_core/output/frame_output.hpp"
#include "touchstone/examples/training_run/setting/setting.hpp"

namespace touchstone::training {

/// Where flights are shown; empty: nowhere.
struct OutputOptions {
  std::string records{};     ///< folder: a record (adapters/recorder) of every flight
  std::string animations{};  ///< folder: glTF of every flight, from its record
  std::string cigi{};        ///< HOST:PORT of an image generator
  /// How long the end of a record waits for who takes nothing (a pipe that nobody reads).
  std::chrono::milliseconds patience{1000};
  std::string records_option = "--record";  ///< what the program calls the option of `records`, for errors
};

/// @param flights whose files are to come: names without extension.
/// @throws InputError, one line: an adapter that this build lacks, an invalid address, a folder that
/// cannot be made, animations without records, a file that stands in the way and is not of an earlier run.
void prepare_outputs(const OutputOptions& options, const std::vector<std::string>& flights);
/// The options that this build has, and what the others lack; one line each.
std::string outputs_text();

/// Counts of the frames that one receiver was brought.
struct OutputFigures {
  std::string receiver;
  OutputStatus status;
  std::string error;  ///< what went wrong besides; empty: nothing
};

/// The receivers of one flight. What they lose they count; none ends the flight.
class FlightOutputs {
 public:
  /// @param name of the flight's files, without extension. @param is_shown on the image generator, in real
  /// time.
  /// @throws InputError: a file that cannot be made, a host that is not found.
  FlightOutputs(const OutputOptions& options, const Setting& setting, const std::string& name, bool is_shown);
  ~FlightOutputs();

  std::span<FrameOutput* const> receivers() const;
  bool is_in_real_time() const;
  /// Ends the record: one of each receiver. Later calls do nothing.
  std::vector<OutputFigures> end();
  /// After end(): from the record, which may take long. One where there is an animation, else none.
  std::vector<OutputFigures> write_animation();
  /// Both.
  std::vector<OutputFigures> close();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace touchstone::training
