#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/registry.hpp"

/// @file
/// A backend as a program: it reads pairs from stdin and writes answers to stdout, in any language; the
/// protocol is process_engine/README.md. Each workspace has a process of its own, so any number of threads
/// may ask; one that a workspace leaves waiting serves the narrowphase's next workspace.
///
/// Nothing that the engine does is ours: where it crashes, hangs, ends, answers too little, too much or
/// something else than was asked, the pair it was busy with is `failed`, the reason is reported ("failed,
/// signal 11 on pair 31"), it is started anew, and the other pairs are asked on. Answers are held against
/// narrowphase/answer_check.hpp.

namespace touchstone {

/// Time limits that an engine may take until its first sign: interpreters and libraries take their time.
inline constexpr int kLimitsOfAStart = 5;

/// How an engine is run.
struct ProcessEngineOptions {
  std::vector<std::string> command;  ///< program (looked for in PATH) and arguments
  /// An engine that neither takes nor gives a byte for so long hangs; it may start for kLimitsOfAStart of
  /// that.
  std::chrono::milliseconds time_limit{2000};
  /// The restarts of one workspace; after them its pairs are `failed` unasked. After 4 (max_restarts + 1)
  /// failures in a row without an answer between them, counted over all workspaces, no process is started
  /// again in any.
  int max_restarts = 16;
  /// Time limits that one question may take, and the solids for each 4 096 (in lines: 256) of them: an
  /// engine that gives or takes a byte now and then is ended, too.
  int limits_of_a_question = 30;
  /// Time limits that the questions of all workspaces may take together, but for 0.06 of one each and 0.01 a
  /// pair, which are free; then nothing is asked any more: an engine that sleeps in each would keep its
  /// caller for days.
  int limits_in_all = 300;
  /// Gets each failure, one line; from any thread, one at a time. Must not throw. Empty: to stderr.
  std::function<void(std::string_view)> on_failure = {};
};

/// Starts the engine once, for its greeting, and adds its narrowphase. Returns the backend's name.
/// @throws InputError naming the command: it cannot be started, its greeting is invalid or of another
/// version, its name is taken.
std::string register_process_engine(BackendRegistry& registry, const ProcessEngineOptions& options);

}  // namespace touchstone
