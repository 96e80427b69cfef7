#include "touchstone/examples/bench/site/index_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "touchstone/examples/bench/site/case_pages.hpp"
#include "touchstone/examples/bench/site/path_pages.hpp"
#include "touchstone/examples/compare_backends/figures/speed_error_plot.hpp"
#include "touchstone/examples/compare_backends/page/html.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

constexpr const char* kOurs = "native";

const Cell* cell_of(const Entry& entry, const std::string& set, QueryKind query) {
  const auto found = entry.sets.find(set);
  return found == entry.sets.end() ? nullptr : &found->second[index_of(query)];
}

// ---- where ours loses

/// The fastest engine of the same file without a wrong or coarse answer to the set, where it beats ours.
std::string faster_right_one(const BenchResults& results, const Entry& ours, const std::string& set,
                             QueryKind query) {
  const Cell* mine = cell_of(ours, set, query);
  if (mine == nullptr || !mine->single) return "";
  const Entry* best = nullptr;
  double least = mine->single->median_ns;
  for (const Entry& entry : results.entries) {
    const Cell* cell = entry.file == ours.file ? cell_of(entry, set, query) : nullptr;
    if (cell == nullptr || !cell->single || grade(*cell) != Grade::right || cell->wrong.unsupported > 0)
      continue;
    if (cell->single->median_ns >= least) continue;
    least = cell->single->median_ns;
    best = &entry;
  }
  if (best == nullptr) return "";
  return fmt::format("<li>{}, {}: {} takes {:.2f} of our time and is right</li>\n", xml_text(set),
                     to_string(query), xml_text(best->engine), least / mine->single->median_ns);
}

std::string losses(const BenchResults& results, const std::vector<Entry>& newest) {
  std::string list;
  for (const Entry& entry : newest) {
    if (entry.engine != kOurs) continue;
    for (const std::string& set : results.sets) {
      for (const QueryKind query : kQueryKinds) {
        const Cell* cell = cell_of(entry, set, query);
        if (cell != nullptr && grade(*cell) != Grade::right && grade(*cell) != Grade::not_answered)
          list +=
              fmt::format("<li>{}, {}: {}</li>\n", xml_text(set), to_string(query), xml_text(text_of(*cell)));
        list += faster_right_one(results, entry, set, query);
      }
    }
  }
  return "<section id='losses'><h2>Where ours loses</h2>\n<p>Sets of one pair a call, streamed from memory, "
         "in one run, in which <code>native</code> is wrong, coarse, or slower than an engine that is right "
         "in all of the set.</p>\n" +
         (list.empty() ? "<p>Nowhere in these files.</p>\n" : "<ul>\n" + list + "</ul>\n") + "</section>\n";
}

// ---- tables

/// A number is not broken at its exponent's sign, where browsers do.
std::string unbroken(std::string text) {
  for (std::size_t at = 0; (at = text.find("e-", at)) != std::string::npos; ++at)
    text.replace(at, 2, "e\u2011");
  return text;
}

std::string markup(const Entry& entry, const std::string& set, QueryKind query) {
  const Cell* cell = cell_of(entry, set, query);
  if (cell == nullptr) return "<span class='no-cell'>not run</span>";
  const std::string text = unbroken(xml_text(text_of(*cell)));
  if (faults(*cell).empty()) return fmt::format("<span class='{}'>{}</span>", style_of(grade(*cell)), text);
  return fmt::format("<a class='wrong-cell' href='cases/{}.html#{}'>{}</a>", xml_text(set),
                     xml_text(cell_name(entry, set, query)), text);
}

double mean_ns(const Entry& entry, QueryKind query) {
  double sum = 0;
  for (const auto& [set, cells] : entry.sets) sum += median(cells[index_of(query)].single);
  return sum / static_cast<double>(entry.sets.size());
}

std::string ns_text(double ns) { return std::isnan(ns) ? "-" : fmt::format("{:.0f}", ns); }

std::string table(const BenchResults& results, std::vector<Entry> newest,
                  const std::vector<std::string>& marks, QueryKind query) {
  std::erase_if(newest, [&](const Entry& entry) { return entry.wrong(query).supported() == 0; });
  const auto faults_of = [&](const Entry& entry) {
    const Wrongness wrong = entry.wrong(query);
    return wrong.total() + wrong.unsupported;
  };
  std::stable_sort(newest.begin(), newest.end(),
                   [&](const Entry& x, const Entry& y) { return faults_of(x) < faults_of(y); });
  std::vector<std::string> header = {"engine", "wrong or open", "mean of medians [ns]"};
  header.insert(header.end(), results.sets.begin(), results.sets.end());
  HtmlTable rows(header);
  for (const Entry& entry : newest) {
    std::vector<std::string> row = {fmt::format("<span title='{}'>{}{}</span>", xml_text(entry.description),
                                                mark_svg(marks, entry.engine), xml_text(entry.engine)),
                                    format_count(entry.wrong(query).total()), ns_text(mean_ns(entry, query))};
    for (const std::string& set : results.sets) row.push_back(markup(entry, set, query));
    rows.add_markup(row);
  }
  return fmt::format("<section id='{0}'><h2>{0}</h2>\n{1}</section>\n", to_string(query), rows.str());
}

// ---- speed against error

std::string plots(const BenchResults& results, const std::vector<Entry>& newest,
                  const std::vector<std::string>& marks) {
  std::vector<SetResult> sets;
  for (const std::string& set : results.sets) sets.push_back(set_result(newest, set));
  const PlotAxes axes = axes_for(sets);
  std::string html =
      "<section id='speed'><h2>Speed against error</h2>\n<p>One pair a call. An engine with a wrong or "
      "missing answer earns no speed mark: it stands hollow at the right, with its count. Engines in "
      "processes are timed with their pipe, a round trip a pair.</p>\n";
  for (const SetResult& set : sets) {
    html += fmt::format("<details{}><summary><h3>{}</h3></summary>\n", &set == &sets.front() ? " open" : "",
                        xml_text(set.name));
    for (const QueryKind query : kQueryKinds)
      html += fmt::format("<figure>{}<figcaption>{}</figcaption></figure>\n",
                          speed_error_plot(set, query, axes, marks, false), to_string(query));
    html += "</details>\n";
  }
  return html + "</section>\n";
}

// ---- history

std::string history(const BenchResults& results) {
  HtmlTable rows({"engine", "version", "measured", "file", "overlap", "distance", "manifold",
                  "worst distance over S", "distance, mean of medians [ns]"});
  // A row a file, engine by engine.
  std::set<std::string> names;
  for (const Entry& entry : results.entries)
    if (!entry.sets.empty()) names.insert(entry.engine);
  for (const std::string& name : names) {
    for (const Entry& entry : results.entries) {
      if (entry.engine != name) continue;
      std::vector<std::string> row = {xml_text(name), xml_text(entry.description), xml_text(entry.measured),
                                      fmt::format("<a href='raw/{0}'>{0}</a>", xml_text(entry.file))};
      for (const QueryKind query : kQueryKinds) {
        const Wrongness wrong = entry.wrong(query);
        row.push_back(wrong.supported() == 0 ? "-"
                                             : fmt::format("{} of {}", unbroken_count(wrong.total()),
                                                           unbroken_count(wrong.supported())));
      }
      const double worst = entry.worst_over_scale(QueryKind::distance);
      row.push_back(std::isnan(worst) ? "-" : fmt::format("{:.1e}", worst));
      row.push_back(ns_text(mean_ns(entry, QueryKind::distance)));
      rows.add_markup(row);
    }
  }
  return "<section id='history'><h2>History by version</h2>\n<p>Every engine of every file, in the order in "
         "which the files were named: wrong or open answers of those asked. Engines of this project have the "
         "version that measured. Times are comparable on one machine (below) alone.</p>\n" +
         rows.str() + "</section>\n";
}

std::string origins(const BenchResults& results, const Corpus& corpus) {
  HtmlTable files({"file", "machine"});
  std::set<std::string> seen;
  for (const Entry& entry : results.entries)
    if (seen.insert(entry.file).second)
      files.add_markup(
          {fmt::format("<a href='raw/{0}'>{0}</a>", xml_text(entry.file)), xml_text(entry.machine)});
  HtmlTable sets({"set", "pairs", "what", "SHA-256 of its pairs"});
  for (const CorpusSet& set : corpus.sets)
    sets.add({xml_text(set.name), format_count(set.cases), set.description, set.pairs_sha256});
  return fmt::format(
             "<section id='origins'><h2>Corpus and results</h2>\n<p>{} {}; its manifest's SHA-256 is "
             "<code>{}</code>.</p>\n",
             xml_text(corpus.name), xml_text(corpus.version), corpus.sha256) +
         sets.str() + files.str() + "</section>\n";
}

}  // namespace

std::string index_page(const BenchResults& results, const Corpus& corpus) {
  const std::vector<Entry> newest = results.newest();
  std::vector<std::string> marks;
  for (const Entry& entry : newest)
    if (!entry.sets.empty()) marks.push_back(entry.engine);
  std::string body = fmt::format(
      "<p>Contact checks on the same pairs of convex solids, judged by an exact one. A cell says what was "
      "wrong, then the dearest answer over S (the larger of size and coordinates). Red: a wrong class, a "
      "failure, a missing value, or an answer that costs {:g} S, undecided ones too; it opens its cases. "
      "Yellow: undecided, or an answer that costs {:g} S. Rules: "
      "<code>examples/bench/README.md</code>.</p>\n",
      kFar, kCoarse);
  body += losses(results, newest);
  for (const QueryKind query : kQueryKinds) body += table(results, newest, marks, query);
  body += path_section(results, newest) + plots(results, newest, marks) + history(results) +
          origins(results, corpus);
  return site_page(corpus.name + " " + corpus.version, body, "");
}

}  // namespace touchstone::comparison
