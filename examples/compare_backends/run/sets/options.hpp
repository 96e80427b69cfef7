#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/judge/choice.hpp"
#include "touchstone/examples/compare_backends/run/shards/shard.hpp"
#include "touchstone/examples/program/options/choices.hpp"

namespace touchstone::comparison {

struct Options {
  std::vector<std::string> backends;   ///< empty: all
  std::vector<std::string> plugins;    ///< shared libraries with a backend each
  std::vector<std::string> engines;    ///< commands of engines as processes
  std::optional<double> engine_limit;  ///< [s], for which they may be silent; none: each kind's own
  std::vector<std::string> families;   ///< empty: all
  std::vector<std::string> scenes;
  std::vector<SceneSetting> scene_settings;
  std::string pairs_file;            ///< of --pairs or --capture
  bool is_capture = false;           ///< of --capture: an engine's answers are expected in it
  std::string corpus;                ///< folder of --corpus
  std::string dynamics_file;         ///< results.json of dynamics_run; empty: none
  std::optional<std::size_t> count;  ///< pairs a family
  std::uint64_t seed = 1;
  std::optional<double> max_error;  ///< [m]; of `choice` where it is given
  Choice choice;                    ///< its query is --query
  std::string case_id;
  std::string output = "report";
  int repetitions = 9;
  int threads = 2;
  bool families_given = false;
  bool no_families = false;
  bool no_broadphase = false;
  bool quick = false;
  bool list = false;
  std::optional<Shard> shard;  ///< of --shard
  /// The words of the command line without --shard and --output, which parts of one run may differ in.
  std::vector<std::string> shared_arguments;
  std::string command_line;  ///< quoted, as a shell takes it back

  std::size_t pair_count() const { return count.value_or(quick ? 500 : 20000); }
};

}  // namespace touchstone::comparison
