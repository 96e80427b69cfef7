#include "touchstone/tests/fit/table/results_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "touchstone/examples/program/terminal/machine.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::test {
namespace {

using program::format_count;

std::string percent(double share) { return fmt::format("{:.3g} %", 100.0 * share); }

std::string cells(const std::vector<std::string>& texts) {
  std::string line = "|";
  for (const std::string& text : texts) line += " " + text + " |";
  return line + "\n";
}

std::string head(const std::vector<std::string>& names) {
  std::string line = cells(names) + "|---|";
  for (std::size_t i = 1; i < names.size(); ++i) line += "---:|";
  return line + "\n";
}

bool is_late(const FitRow& row) { return row.fit_seconds + row.proof_seconds > kAskedSeconds; }

std::string names_of(const std::vector<FitRow>& rows, bool (*is_meant)(const FitRow&)) {
  std::string names;
  for (const FitRow& row : rows)
    if (is_meant(row)) names += (names.empty() ? "" : ", ") + row.mesh;
  return names.empty() ? "none" : names;
}

std::string section(double asked, const std::vector<FitRow>& rows) {
  std::string text =
      fmt::format("## Within {} of the diagonal\n\n", percent(asked)) +
      head({"mesh", "triangles", "hexahedra", "error", "fit [s]", "proof [s]", "uncovered", "of"});
  std::size_t hexahedra = 0, samples = 0;
  for (const FitRow& row : rows) {
    if (!row.refused.empty()) {
      text += cells({row.mesh, format_count(row.triangles), row.refused, "-", "-", "-", "-", "-"});
      continue;
    }
    hexahedra += row.hexahedra;
    samples += row.judged.samples();
    text += cells({row.mesh, format_count(row.triangles), std::to_string(row.hexahedra), percent(row.error),
                   fmt::format("{:.1f}", row.fit_seconds), fmt::format("{:.1f}", row.proof_seconds),
                   format_count(row.judged.uncovered()), format_count(row.judged.samples())});
  }
  text += fmt::format("\n{} meshes, {} hexahedra, {} samples. Not proven: {}. With uncovered samples: {}. ",
                      rows.size(), hexahedra, format_count(samples),
                      names_of(rows, [](const FitRow& row) { return !row.refused.empty(); }),
                      names_of(rows, [](const FitRow& row) { return row.judged.uncovered() > 0; }));
  return text +
         fmt::format("More than {:.0f} s for fit and proof: {}; for the fit alone: {}.\n\n", kAskedSeconds,
                     names_of(rows, is_late),
                     names_of(rows, [](const FitRow& row) { return row.fit_seconds > kAskedSeconds; }));
}

std::string peers_section(const FitTable& table) {
  // Versions, and the table's head.
  std::string text = "## Approximate convex decompositions of the same meshes\n\n";
  for (const std::string& peer : table.peers) text += "- " + peer + "\n";
  if (table.peer_rows.empty()) return text;
  text +=
      "\nEach with its own defaults, on one thread. Excess: the largest distance of a point of a hull to the "
      "solid. Uncovered: share of\nthe samples that no hull holds, and that none holds by more than 0.1 % of "
      "the largest "
      "coordinate. Ours: hexahedra of a cover\nwithin that excess, with 12 triangles each.\n\n" +
      head({"mesh", "by", "hulls", "triangles", "excess", "time [s]", "uncovered", "by 0.1 %", "ours",
            "triangles"});
  // A row for each mesh and peer, and where ours has fewer triangles.
  std::size_t compared = 0, fewer = 0;
  for (const PeerRow& row : table.peer_rows) {
    if (!row.failure.empty()) {
      text += cells({row.mesh, row.method, row.failure, "-", "-", "-", "-", "-", "-", "-"});
      continue;
    }
    const auto share = [](const JudgedSamples& judged) {
      return percent(static_cast<double>(judged.uncovered()) /
                     static_cast<double>(std::max<std::size_t>(judged.samples(), 1)));
    };
    if (row.hexahedra) ++compared, fewer += 12 * *row.hexahedra <= row.triangles ? 1 : 0;
    text += cells({row.mesh, row.method, std::to_string(row.hulls), format_count(row.triangles),
                   percent(row.excess), fmt::format("{:.1f}", row.seconds), share(row.judged),
                   share(row.judged_far), row.hexahedra ? std::to_string(*row.hexahedra) : "-",
                   row.hexahedra ? format_count(12 * *row.hexahedra) : "-"});
  }
  return text + fmt::format("\nOurs has no more triangles in {} of {} rows.\n", fewer, compared);
}

}  // namespace

std::string row_text(const FitRow& row) {
  if (!row.refused.empty()) return fmt::format("{} at {}: {}\n", row.mesh, percent(row.asked), row.refused);
  return fmt::format(
      "{} at {}: {} hexahedra, error {}, proven; fit {:.1f} s, proof {:.1f} s; {} of {} samples uncovered\n",
      row.mesh, percent(row.asked), row.hexahedra, percent(row.error), row.fit_seconds, row.proof_seconds,
      row.judged.uncovered(), format_count(row.judged.samples()));
}

std::string row_text(const PeerRow& row) {
  if (!row.failure.empty()) return fmt::format("{} by {}: {}\n", row.mesh, row.method, row.failure);
  return fmt::format("{} by {}: {} hulls, {} triangles, excess {}, {:.1f} s; {} of {} samples uncovered{}\n",
                     row.mesh, row.method, row.hulls, row.triangles, percent(row.excess), row.seconds,
                     row.judged.uncovered(), format_count(row.judged.samples()),
                     row.hexahedra ? fmt::format("; ours at that excess: {} hexahedra", *row.hexahedra) : "");
}

std::string results_page(const FitTable& table) {
  std::string text = program::page_head("Covers of a folder of meshes", table.command) +
                     fmt::format(
                         "Every cover is proven (`adapters/cover_proof`), then judged by Bullet in double "
                         "precision: {} random points a mesh, half of its\n"
                         "surface and half of its inside, are looked for in the union. The judge shares no "
                         "code with the fitter and the proof. Times are\n"
                         "of one core, by the processor's clock.\n\n",
                         format_count(table.samples));
  std::map<double, std::vector<FitRow>, std::greater<>> by_error;
  for (const FitRow& row : table.rows) by_error[row.asked].push_back(row);
  for (const auto& [asked, rows] : by_error) text += section(asked, rows);
  return table.peers.empty() ? text : text + peers_section(table);
}

std::size_t count_uncovered(const FitTable& table) {
  return static_cast<std::size_t>(std::count_if(table.rows.begin(), table.rows.end(), [](const FitRow& row) {
    return !row.refused.empty() || row.judged.uncovered() > 0;
  }));
}

}  // namespace touchstone::test
