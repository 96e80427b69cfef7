#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/names.hpp"
#include "touchstone/examples/measures/runs/backend_run.hpp"

// Backends that cannot live in this process (one process holds one precision of Bullet) run in a worker
// process, on the same pairs, with the same timing code. Job and answers travel as files of plain bytes: both
// ends are built together.

namespace touchstone::comparison {

inline constexpr std::chrono::milliseconds kWorkerTimeLimit{60'000};

/// A worker program and what it offers. A program that cannot be run offers nothing and names the reason.
struct Worker {
  std::filesystem::path program;
  std::vector<std::string> arguments;                         ///< before those of describing and running
  std::vector<std::pair<std::string, std::string>> backends;  ///< name and description
  std::string failure;
  /// How long an engine may be busy with a call, or the worker with what is between calls; five times that
  /// until it has started and read its job (kLimitsOfAStart).
  std::chrono::milliseconds time_limit = kWorkerTimeLimit;
  /// How it hung, for all copies: from then on it is not run again. "": it did not. One thread at a time.
  std::shared_ptr<std::string> hang = std::make_shared<std::string>();

  bool offers(std::string_view name) const;
};

Worker describe_worker(const std::filesystem::path& program, const std::vector<std::string>& arguments = {},
                       std::chrono::milliseconds time_limit = kWorkerTimeLimit);

/// As run_backends, in the worker. If it dies or hangs every case of these backends is `failed` and
/// BackendAnswers::failure tells how; after a hang all later calls fail at once, so that an engine costs one
/// limit and not one a set. `progress` is called (with 0) while it runs; what it throws ends the worker
/// first.
std::vector<BackendAnswers> run_in_worker(const Worker& worker, std::span<const std::string> backends,
                                          const PairSet& set, const MeasureOptions& options,
                                          const Progress& progress = {});

/// The worker's side: main() of a program that offers what `add_backends` registers.
int worker_main(int argc, char** argv, const std::function<void(BackendRegistry&)>& add_backends);

}  // namespace touchstone::comparison
