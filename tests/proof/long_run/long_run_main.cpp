#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"
#include "touchstone/tests/proof/long_run/long_run.hpp"
#include "touchstone/tests/proof/pairs/families.hpp"
#include "touchstone/tests/proof/pairs/pair_text.hpp"

// The long run, not in CI: ten million pairs of all families, `native` against two independent truths. Prints
// a table and writes long_run.json and, where something is wrong, failing_pairs.json for compare_backends
// --pairs.

namespace {

using namespace touchstone;
using namespace touchstone::proof;
using Json = nlohmann::ordered_json;

std::atomic<bool> interrupted{false};

std::string percent(std::size_t part, std::size_t whole) {
  return whole == 0 ? "-"
                    : fmt::format("{:.3f} %", 100.0 * static_cast<double>(part) / static_cast<double>(whole));
}

class ProgressText {
 public:
  explicit ProgressText(std::size_t count) : count_(count) {}
  void operator()(std::size_t done) {
    const auto now = std::chrono::steady_clock::now();
    const auto pause = std::chrono::seconds(isatty(STDERR_FILENO) == 1 ? 1 : 60);
    if (now - last_ < pause) return;
    last_ = now;
    const double rate = static_cast<double>(done) / std::chrono::duration<double>(now - start_).count();
    const double left = static_cast<double>(count_ - std::min(done, count_)) / rate;
    fmt::print(stderr, "{}{} of {} pairs, {:.0f} pairs/s, {:.0f} s left{}",
               isatty(STDERR_FILENO) == 1 ? "\r\033[K" : "", done, count_, rate, left,
               isatty(STDERR_FILENO) == 1 ? "" : "\n");
    std::fflush(stderr);
  }

 private:
  std::size_t count_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now(), last_ = start_;
};

std::string class_table(const LongRunResult& result) {
  using program::format_count;
  program::TextTable table({"family", "pairs", "separated", "touching", "penetrating", "by filter",
                            "by integers", "unsettled", "missed", "phantom", "wrong sign"});
  const auto add = [&](std::string_view name, const FamilyTally& t) {
    table.add({std::string(name), format_count(t.pairs), format_count(t.separated), format_count(t.touching),
               format_count(t.penetrating), percent(t.by_filter, t.pairs),
               percent(t.pairs - t.by_filter - t.unsettled, t.pairs), format_count(t.unsettled),
               format_count(t.missed), format_count(t.phantom), format_count(t.wrong_sign)});
  };
  for (std::size_t i = 0; i < result.families.size(); ++i)
    if (result.families[i].pairs > 0) add(families()[i].name, result.families[i]);
  add("all", result.total());
  return table.str();
}

std::string distance_table(const LongRunResult& result) {
  using program::format_count;
  std::vector<std::string> header = {"distances off by [ulp]", "compared"};
  for (const std::string_view name : kUlpNames) header.emplace_back(name);
  for (const char* name : {"worst/S", "beyond bound", "truths differ"}) header.emplace_back(name);
  program::TextTable table(header);
  const auto add = [&](std::string_view name, const FamilyTally& t) {
    std::vector<std::string> row = {std::string(name), format_count(t.distances)};
    for (const std::size_t count : t.ulps) row.push_back(format_count(count));
    row.push_back(program::format_error(t.worst_over_S));
    row.push_back(format_count(t.beyond_bound));
    row.push_back(format_count(t.truths_differ));
    table.add(row);
  };
  for (std::size_t i = 0; i < result.families.size(); ++i)
    if (result.families[i].pairs > 0) add(families()[i].name, result.families[i]);
  add("all", result.total());
  return table.str();
}

Json tally_json(std::string_view name, const FamilyTally& t) {
  Json ulps;
  for (std::size_t i = 0; i < t.ulps.size(); ++i) ulps[std::string(kUlpNames[i])] = t.ulps[i];
  return {{"family", name},
          {"pairs", t.pairs},
          {"separated", t.separated},
          {"touching", t.touching},
          {"penetrating", t.penetrating},
          {"settled_by_filter", t.by_filter},
          {"unsettled", t.unsettled},
          {"missed", t.missed},
          {"phantom", t.phantom},
          {"wrong_sign", t.wrong_sign},
          {"distances", t.distances},
          {"ulps", ulps},
          {"worst_over_S", t.worst_over_S},
          {"beyond_bound", t.beyond_bound},
          {"truths_differ", t.truths_differ}};
}

std::string result_json(const LongRunOptions& options, const LongRunResult& result) {
  Json list = Json::array(), faults = Json::array();
  for (std::size_t i = 0; i < result.families.size(); ++i)
    list.push_back(tally_json(families()[i].name, result.families[i]));
  for (const Fault& fault : result.faults)
    faults.push_back(
        {{"family", families()[fault.family].name}, {"index", fault.index}, {"what", fault.what}});
  const Json json = {{"seed", options.seed},
                     {"threads", options.threads},
                     {"seconds", result.seconds},
                     {"families", list},
                     {"total", tally_json("all", result.total())},
                     {"faults", faults}};
  return json.dump(2) + "\n";
}

std::string failing_pairs(const LongRunOptions& options, const LongRunResult& result) {
  std::string text;
  std::string last;
  for (const Fault& fault : result.faults) {
    const std::string id = fmt::format("{}-{}-{}", families()[fault.family].name, options.seed, fault.index);
    if (id == last) continue;
    last = id;
    text +=
        (text.empty() ? "[\n" : ",\n") + pair_text(make_pair(fault.family, options.seed, fault.index), id);
  }
  return text + "\n]\n";
}

void write(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path);
  file << text;
  if (!file.flush()) throw std::runtime_error("cannot write " + path.string());
}

/// @throws InputError for a name that is no family's.
std::size_t family_index(const std::string& name) {
  for (std::size_t i = 0; i < families().size(); ++i)
    if (families()[i].name == name) return i;
  throw InputError("no family '" + name + "'");
}

int run(int argc, char** argv) {
  // Families are known by name before anything runs, and the folder is there.
  LongRunOptions options;
  std::vector<std::string> names;
  std::string output = "long_run";
  CLI::App app{"native against two independent truths on millions of pairs"};
  app.add_option("--count", options.count, "Pairs, shared by the families")->capture_default_str();
  app.add_option("--distances", options.distances, "Of these with their distance compared")
      ->capture_default_str();
  app.add_option("--families", names, "Families (default: all)");
  app.add_option("--seed", options.seed, "Seed of the families")->capture_default_str();
  app.add_option("--threads", options.threads, "Threads")->check(CLI::Range(1, 1024))->capture_default_str();
  app.add_option("--output", output, "Folder for long_run.json and failing_pairs.json")
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  options.stop = &interrupted;
  for (const std::string& name : names) options.families.push_back(family_index(name));
  std::filesystem::create_directories(output);

  // The run says how far it is, and stops after a signal.
  ProgressText progress(options.count);
  const LongRunResult result = long_run(options, make_native, [&](std::size_t done) { progress(done); });
  if (isatty(STDERR_FILENO) == 1) fmt::print(stderr, "\r\033[K");
  // Tables, files, and how to see a fault again.
  const FamilyTally total = result.total();
  write(std::filesystem::path(output) / "long_run.json", result_json(options, result));
  fmt::print("{}\n{}\n{} pairs in {:.1f} s on {} threads: {:.0f} pairs/s{}\n", class_table(result),
             distance_table(result), program::format_count(total.pairs), result.seconds, options.threads,
             static_cast<double>(total.pairs) / result.seconds, interrupted ? " (interrupted)" : "");
  for (const Fault& fault : result.faults)
    fmt::print("{}:{}  {}\n", families()[fault.family].name, fault.index, fault.what);
  if (!result.faults.empty()) {
    write(std::filesystem::path(output) / "failing_pairs.json", failing_pairs(options, result));
    fmt::print("replay: compare_backends --families none --pairs {}/failing_pairs.json\n", output);
  }
  return result.faults.empty() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGINT, [](int) { interrupted = true; });
  std::signal(SIGTERM, [](int) { interrupted = true; });
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "long_run: " << error.what() << "\n";
    return 2;
  }
}
