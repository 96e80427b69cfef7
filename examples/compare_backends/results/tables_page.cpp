#include "touchstone/examples/compare_backends/results/tables_page.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/results/markdown.hpp"
#include "touchstone/examples/compare_backends/results/results_file.hpp"
#include "touchstone/examples/program/files/json_error.hpp"
#include "touchstone/examples/program/terminal/program.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

using Cells = std::vector<std::string>;

std::vector<std::string> backend_names(const Json& results) {
  std::vector<std::string> names;
  for (const Json& backend : results.at("backends")) names.push_back(backend.at("name"));
  return names;
}

const Json* backend_of(const Json& set, const std::string& name) {
  for (const Json& backend : set.at("backends"))
    if (backend.at("backend") == name) return &backend;
  return nullptr;
}

// ---- cells, by set and backend

double median_of(const Json& timing) { return timing.is_null() ? kNaN : number_of(timing.at("median_ns")); }

std::string time_cell(const Json& query, const char* row) { return format_ns(median_of(query.at(row))); }

// "0", "3 (+12)": wrong classes, and those left open; "-" where the backend answers none.
std::string wrong_cell(const Json& query) {
  if (!query.contains("wrong")) return "-";
  const Json& wrong = query.at("wrong");
  const auto count = [&](const char* key) { return wrong.at(key).get<std::size_t>(); };
  if (count("unsupported") == count("cases")) return "-";
  const std::size_t classes = count("missed") + count("phantom");
  const std::size_t open = count("undecided") + count("failed") + count("missing_value");
  std::string text = format_count(classes);
  if (open > 0) text += fmt::format(" (+{})", format_count(open));
  if (count("unsupported") > 0) text += fmt::format(", {} unsupported", format_count(count("unsupported")));
  return text;
}

// Worst of two measures over S; a measure that no case carries is left out.
std::string error_cell(const Json& backend, std::initializer_list<const char*> measures) {
  double worst = kNaN;
  for (const char* measure : measures) {
    if (!backend.contains("errors")) continue;
    const Json& stats = backend.at("errors").at(measure).at("over_S");
    if (stats.is_null()) continue;
    const double value = number_of(stats.at("worst"));
    worst = std::isnan(worst) ? value : std::max(worst, value);
  }
  return format_error(worst);
}

// One row a set, one column a backend; a column without any figure is left out, and so is a table without any
// column.
template <typename Cell>
std::string set_table(const Json& results, const std::string& title, const Cell& cell) {
  std::vector<Cells> rows = {{"pairs"}};
  for (const Json& set : results.at("pair_sets")) rows.push_back({set.at("name").get<std::string>()});
  for (const std::string& name : backend_names(results)) {
    Cells column = {name};
    for (const Json& set : results.at("pair_sets")) {
      const Json* const backend = backend_of(set, name);
      column.push_back(backend == nullptr ? "-" : cell(*backend));
    }
    if (std::all_of(column.begin() + 1, column.end(), [](const std::string& text) { return text == "-"; }))
      continue;
    for (std::size_t r = 0; r < rows.size(); ++r) rows[r].push_back(column[r]);
  }
  if (rows.front().size() == 1) return "";
  std::string text = title + ":\n\n" + markdown_head(rows.front(), 1);
  for (std::size_t r = 1; r < rows.size(); ++r) text += markdown_row(rows[r]);
  return text + "\n";
}

// ---- sections

std::string head(const Json& results) {
  const Json& machine = results.at("machine");
  const std::string date = results.value("date", "");  // results of older versions have none
  std::string text = fmt::format(
      "# Speed against error, in tables\n\nTouchstone {}; {} ({}), {} hardware threads, {}; {}, {}{}.\n"
      "Written by `compare_backends tables` from the results of `{}`.\n",
      results.at("version").get<std::string>(), machine.at("cpu").get<std::string>(),
      machine.at("instruction_set").get<std::string>(), machine.at("hardware_threads").get<int>(),
      machine.at("system").get<std::string>(), machine.at("compiler").get<std::string>(),
      machine.at("build_type").get<std::string>(), date.empty() ? "" : "; " + date,
      results.at("command").get<std::string>());
  if (results.at("partial").get<bool>())
    text += "\n**This run ended early: sets and sizes that it did not come to are not here.**\n";
  return text +
         "\nTimes are medians [ns a pair] of one run, in which the backends take turns block by block: read "
         "ratios. *Batch* is many pairs in one call. *Raw* is the engine's own cheapest call on objects that "
         "are posed and in the cache: a floor. *Wrong* counts wrong classes against `exact`; answers left "
         "open (undecided, failed, without a value) stand in brackets. \"-\": the backend does not answer "
         "this, or was not measured.\n\n";
}

std::string backends(const Json& results) {
  std::string text = markdown_head({"backend", "is"}, 2);
  for (const Json& backend : results.at("backends"))
    text += markdown_row(
        {"`" + backend.at("name").get<std::string>() + "`", backend.at("description").get<std::string>()});
  for (const Json& gap : results.at("gaps"))
    text += fmt::format("\nMissing: {}. {}.\n", gap.at("what").get<std::string>(),
                        gap.at("why").get<std::string>());
  return text + "\n";
}

// Mean over the sets of a row's medians; NaN where one lacks it.
double mean_time(const Json& results, const std::string& backend, const std::string& query, const char* row) {
  double sum = 0.0;
  for (const Json& set : results.at("pair_sets")) {
    const Json* const found = backend_of(set, backend);
    sum += found == nullptr ? kNaN : median_of(found->at("queries").at(query).at(row));
  }
  return sum / static_cast<double>(results.at("pair_sets").size());
}

// Wrong answers of all sets together.
std::string wrong_of_all(const Json& results, const std::string& backend, const std::string& query) {
  Json total = {{"cases", 0},       {"missed", 0}, {"phantom", 0},      {"undecided", 0},
                {"unsupported", 0}, {"failed", 0}, {"missing_value", 0}};
  for (const Json& set : results.at("pair_sets")) {
    const Json* const found = backend_of(set, backend);
    if (found == nullptr || !found->at("queries").at(query).contains("wrong")) return "-";
    for (auto& [key, count] : total.items())
      count =
          count.get<std::size_t>() + found->at("queries").at(query).at("wrong").at(key).get<std::size_t>();
  }
  return wrong_cell({{"wrong", total}});
}

std::string summary(const Json& results) {
  std::string text = markdown_head({"backend", "overlap", "in batches", "wrong", "distance", "in batches",
                                    "wrong", "manifold", "in batches", "wrong"},
                                   1);
  for (const std::string& name : backend_names(results)) {
    Cells line = {"`" + name + "`"};
    for (const char* query : {"overlap", "distance", "manifold"}) {
      line.push_back(format_ns(mean_time(results, name, query, "single")));
      line.push_back(format_ns(mean_time(results, name, query, "batch")));
      line.push_back(wrong_of_all(results, name, query));
    }
    text += markdown_row(line);
  }
  return "## Summary\n\nMeans over the families of the medians [ns a pair], one pair a call and in batches, "
         "and wrong answers of all:\n\n" +
         text + "\n";
}

std::string query_section(const Json& results, const std::string& query) {
  const auto of = [&](const Json& backend) -> const Json& { return backend.at("queries").at(query); };
  const auto times = [&](const std::string& title, const char* row) {
    return set_table(results, title, [&](const Json& backend) { return time_cell(of(backend), row); });
  };
  std::string text = "## " + query + "\n\n" + times("One pair a call [ns]", "single") +
                     times("In batches [ns]", "batch") + times("Raw [ns]", "raw");
  if (!results.at("measured_against_exact").get<bool>()) return text;
  text += set_table(results, "Wrong answers", [&](const Json& backend) { return wrong_cell(of(backend)); });
  if (query == "distance")
    text += set_table(results, "Worst error of distance or depth over S", [](const Json& backend) {
      return error_cell(backend, {"distance", "depth"});
    });
  if (query == "manifold")
    text += set_table(results, "Worst error of the deepest point over S",
                      [](const Json& backend) { return error_cell(backend, {"deepest"}); });
  return text;
}

// ---- broadphases

struct SwarmSize {
  std::size_t objects, hexahedra;
  bool operator==(const SwarmSize&) const = default;
};

SwarmSize size_of(const Json& row) { return {row.at("objects"), row.at("hexahedra_each")}; }

template <typename Range, typename Value>
void add_once(Range& range, const Value& value) {
  if (std::find(range.begin(), range.end(), value) == range.end()) range.push_back(value);
}

std::string broadphase_cell(const Json& row, bool with_overlap) {
  if (row.contains("gap")) return "not run";
  const double ms = number_of(with_overlap ? row.at("with_overlap_ms") : row.at("frame_ms").at("median"));
  return std::isnan(ms) ? "-" : fmt::format("{:.3g}", ms);
}

std::string broadphase_table(const Json& rows, bool with_overlap) {
  std::vector<std::string> names;
  std::vector<SwarmSize> sizes;
  for (const Json& row : rows) {
    add_once(names, row.at("broadphase").get<std::string>());
    add_once(sizes, size_of(row));
  }
  Cells header = {"objects", "hexahedra each"};
  header.insert(header.end(), names.begin(), names.end());
  std::string text = markdown_head(header, 1);
  for (const SwarmSize& size : sizes) {
    Cells line = {format_count(size.objects), format_count(size.hexahedra)};
    for (const std::string& name : names) {
      const auto found = std::find_if(rows.begin(), rows.end(), [&](const Json& row) {
        return row.at("broadphase") == name && size_of(row) == size;
      });
      line.push_back(found == rows.end() ? "-" : broadphase_cell(*found, with_overlap));
    }
    text += markdown_row(line);
  }
  return text + "\n";
}

std::string broadphases(const Json& results) {
  const Json& rows = results.at("broadphases");
  if (rows.empty()) return "";
  std::size_t missed = 0;
  for (const Json& row : rows)
    if (row.contains("missed") && !row.at("missed").is_null()) missed += row.at("missed").get<std::size_t>();
  return fmt::format(
             "## Broadphases\n\nEvery object moves. Update and all pairs [ms a frame]; pairs missed: {}:\n\n",
             format_count(missed)) +
         broadphase_table(rows, false) +
         "With the overlap of those pairs, by the narrowphase of the same name [ms a frame]:\n\n" +
         broadphase_table(rows, true);
}

}  // namespace

std::string tables_page(const Json& results) {
  try {
    std::string page = head(results) + backends(results);
    if (!results.at("pair_sets").empty()) page += summary(results);
    if (!results.at("pair_sets").empty())
      for (const char* query : {"overlap", "distance", "manifold"}) page += query_section(results, query);
    page += broadphases(results);
    while (page.ends_with("\n\n")) page.pop_back();
    return page;
  } catch (const nlohmann::json::exception& error) {
    throw InputError("tables: " + reason_of(error));
  }
}

int run_tables(int argc, const char* const* argv) {
  CLI::App app{"The tables of a finished run as a Markdown page, on standard output."};
  app.name("compare_backends tables");
  std::string file;
  app.add_option("RESULTS.json", file, "results.json of the run")->required();
  if (!parse_command_line(app, argc - 1, argv + 1)) return 0;
  fmt::print("{}", tables_page(parse_results(read_file(file, "tables"), "tables", file)));
  return 0;
}

}  // namespace touchstone::comparison
