#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/run/report.hpp"
#include "touchstone/examples/compare_backends/run/shards/set_answers.hpp"
#include "touchstone/examples/program/files/json.hpp"

namespace touchstone::comparison {

/// A shard's file: a line of JSON that describes it, then its sets as bytes, in that order. It is read by the
/// version that wrote it, built so that its structs lie alike in memory, set_layout().
inline constexpr const char* kShardSchema = "touchstone.compare_backends.shard/1";

/// "shard_3_of_8.bin".
std::string shard_name(Shard shard);

/// Gathers a shard's sets and writes them.
class ShardWriter {
 public:
  /// @param arguments of the run, without --shard and --output.
  /// Makes the folder where it is missing.
  /// @throws InputError where something else stands at the file's name in the folder, or nothing can be
  /// written there.
  ShardWriter(std::filesystem::path folder, Shard shard, std::vector<std::string> arguments);

  /// @param cases of the whole set.
  void add(const std::string& set, std::size_t cases, const SetAnswers& part);
  /// The file appears whole or not at all. A shard that was there is run again. @param report what the run is
  /// of: options, backends, gaps.
  /// @return its path. @throws std::runtime_error when it cannot be written; where something else was put
  /// there meanwhile naming the file that has the shard.
  std::filesystem::path finish(const Report& report);

 private:
  std::filesystem::path file_, partial_;
  Shard shard_;
  std::vector<std::string> arguments_;
  Json sets_ = Json::array();
  std::string bytes_;
};

/// All shards of one run, in place of what it would measure.
class ShardAnswers {
 public:
  /// Reads and holds against each other the heads of all files, and their sets against these. The same
  /// file twice counts once.
  /// @throws InputError naming the file: unreadable, no shard, changed, of another version, build (type,
  /// flags) or run, or a part that another one has; naming the shards that are missing.
  explicit ShardAnswers(const std::vector<std::string>& files);

  /// Of the run, as a user gave them.
  std::vector<std::string> arguments() const;
  /// Holds the files that the options name against those that the shards were made of, and the backends.
  /// @throws InputError naming the first that differs.
  void check(const Report& report) const;
  std::size_t engine_messages() const;
  /// Those that another machine measured than `here`, by their order.
  std::vector<ShardMachine> elsewhere(const Machine& here) const;
  /// @param with_points as a pair file's set has them.
  /// @throws InputError where the shards know no set of that name, or one of other size.
  SetAnswers of(const PairSet& set, bool with_points) const;

 private:
  struct File {
    std::string path;
    Shard shard;
    Json head;
    std::size_t sets_begin;  ///< in the file
  };
  static File read_head(const std::string& path);
  static void check_build(const File& file);
  static void check_sets(const File& file);
  void check_same_run() const;
  void drop_repeated();
  void check_whole() const;

  std::vector<File> files_;  ///< by shard
};

}  // namespace touchstone::comparison
