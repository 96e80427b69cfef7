#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <vector>

#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/tests/benchmarks/pairs/cost_goals.hpp"
#include "touchstone/tests/benchmarks/pairs/cost_table_families.hpp"
#include "touchstone/tests/benchmarks/pairs/cost_timing.hpp"

// The cost of a pair, by family, query and backend, in one process: the table of the contact costs.
//
//   cost_table_benchmark [FAMILY or QUERY or BACKEND or lone or batch]...
//   cost_table_benchmark goals
//
// Each argument keeps the rows that have it as one of their names. Columns are those of cost_timing.hpp [ns].
// `goals` prints what is asked of native beside what it takes, as Markdown: cost_goals.hpp.

namespace touchstone {
namespace {

void print_costs(const Costs& costs, bool is_batch) {
  if (is_batch)
    std::printf(" %8.0f %8s %8s %8s", costs.mean, "", "", "");
  else
    std::printf(" %8.0f %8.0f %8.0f %8.0f", costs.mean, costs.median, costs.p99, costs.worst);
}

void print_row(const BackendRegistry& registry, const CostRow& row) {
  const RowCosts costs = measure_row(registry, row);
  std::printf("%-16s %-9s %-12s %-6s", row.family.c_str(), std::string(to_string(row.kind)).c_str(),
              row.backend.c_str(), row.is_batch ? "batch" : "lone");
  for (const Costs& of : {costs.hot, costs.streamed, costs.cold}) print_costs(of, row.is_batch);
  std::printf(" %6s\n", costs.wrong < 0 ? "-" : std::to_string(costs.wrong).c_str());
  std::fflush(stdout);
}

std::vector<CostRow> all_rows(const BackendRegistry& registry) {
  std::vector<CostRow> rows;
  for (const std::string_view family : cost_table_families()) {
    for (const QueryKind kind : {QueryKind::overlap, QueryKind::distance, QueryKind::manifold}) {
      for (const bool is_batch : {false, true})
        rows.push_back({std::string(family), kind, "native", is_batch});
      for (const std::string& peer : raw_peers(registry, kind))
        rows.push_back({std::string(family), kind, peer, false});
    }
  }
  return rows;
}

/// Whether every argument names the row's family, query, backend or mode. Names of one sort are alternatives.
bool is_wanted(const CostRow& row, const std::vector<std::string>& arguments) {
  const std::array<std::string, 4> names = {row.family, std::string(to_string(row.kind)), row.backend,
                                            row.is_batch ? "batch" : "lone"};
  const auto sort_of = [](const std::string& name) {
    if (name == "lone" || name == "batch") return 3;
    if (name == "overlap" || name == "distance" || name == "manifold") return 1;
    const auto families = cost_table_families();
    return std::find(families.begin(), families.end(), name) != families.end() ? 0 : 2;
  };
  std::array<bool, 4> is_asked{}, is_met{};
  for (const std::string& argument : arguments) {
    const int sort = sort_of(argument);
    is_asked[sort] = true;
    is_met[sort] = is_met[sort] || names[sort] == argument;
  }
  for (int sort = 0; sort < 4; ++sort)
    if (is_asked[sort] && !is_met[sort]) return false;
  return true;
}

void print_table(const BackendRegistry& registry, const std::vector<std::string>& arguments) {
  for (const auto& entry : registry.narrowphases())
    std::printf("# %s: %s\n", entry.name.c_str(), entry.description.c_str());
  std::printf("# %-14s %-9s %-12s %-6s %35s %35s %35s\n", "", "", "", "", "hot [ns]", "streamed [ns]",
              "cold [ns]");
  std::printf("%-16s %-9s %-12s %-6s", "family", "query", "backend", "calls");
  for (int i = 0; i < 3; ++i) std::printf(" %8s %8s %8s %8s", "mean", "median", "99%", "worst");
  std::printf(" %6s\n", "wrong");
  for (const CostRow& row : all_rows(registry))
    if (is_wanted(row, arguments)) print_row(registry, row);
}

}  // namespace
}  // namespace touchstone

int main(int argc, char** argv) {
  using namespace touchstone;
  BackendRegistry registry;
  register_all_backends(registry);
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (!arguments.empty() && arguments.front() == "goals")
    print_goals(registry, argv[0], arguments.size() > 1 ? arguments[1] : "");
  else
    print_table(registry, arguments);
}
