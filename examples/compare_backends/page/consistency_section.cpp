#include <fmt/format.h>

#include "touchstone/examples/compare_backends/page/sections.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

std::string cell(const Change& change, bool with_bits) {
  if (change.cases == 0) return "not asked";
  std::string text = fmt::format("{} classes", format_count(change.classes));
  if (with_bits) text += fmt::format(", {} bits", format_count(change.bits));
  if (change.left_out > 0) text += fmt::format(" ({} left out)", format_count(change.left_out));
  return text + ", " + format_error(change.worst);
}

std::vector<std::string> cells(const Consistency& all) {
  return {cell(all.swapped, true), cell(all.moved, false), cell(all.repeated, true), cell(all.threads, true)};
}

HtmlTable empty_table(const char* first) {
  return HtmlTable({first, "pairs", "(b,a) for (a,b)", "moved rigidly", "again, in reverse", "on threads"});
}

void add_row(HtmlTable& table, const std::string& name, const Consistency& all) {
  std::vector<std::string> row = {name, format_count(all.swapped.cases)};
  for (std::string& text : cells(all)) row.push_back(std::move(text));
  table.add(row);
}

}  // namespace

std::string consistency_section(const Page& page) {
  const Report& report = page.report;
  HtmlTable totals = empty_table("all sets");
  std::string by_set;
  bool any = false;
  // One table has the sums over all sets; a backend's own sets are folded away.
  for (const std::string& name : page.names) {
    const Consistency total = total_consistency(report.sets, name);
    if (total.swapped.cases == 0) continue;
    any = true;
    add_row(totals, page.named(name), total);
    HtmlTable table = empty_table("set");
    for (const SetResult& set : report.sets) {
      for (const BackendResult& backend : set.backends) {
        if (backend.name == name && backend.consistency)
          add_row(table, xml_text(set.name), *backend.consistency);
      }
    }
    by_set += "<details><summary>" + page.named(name) + "</summary>" + table.str() + "</details>\n";
  }
  // Without such checks there is no section.
  if (!any) return "";
  return fmt::format(
             "<h2>Consistency</h2>\n<p>The same pairs asked in other ways, up to {} a set: distances "
             "(overlaps, of a backend without). Each cell: pairs whose class changed; pairs in which a bit "
             "of class, separation or normal changed; the largest change of a separation over S (-: none is "
             "given). Moved: both solids by one rotation and translation, which rounds their vertices, so "
             "bits are not compared, and the class is not of pairs whose exact separation is within 32 eps S "
             "of 0: those left out. A backend that declares itself not thread safe is not asked on "
             "threads.</p>\n",
             format_count(kConsistencyCases)) +
         totals.str() + by_set + source_note("consistency, pair_sets[].backends[].consistency");
}

}  // namespace touchstone::comparison
