#include "touchstone/examples/bench/site/case_pages.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/bench/corpus/corpus_writer.hpp"
#include "touchstone/examples/bench/site/path_pages.hpp"
#include "touchstone/examples/bench/site/reproduction.hpp"
#include "touchstone/examples/bench/site/site_text.hpp"
#include "touchstone/examples/compare_backends/figures/wireframe_plot.hpp"
#include "touchstone/examples/compare_backends/page/embedded_text.hpp"
#include "touchstone/examples/compare_backends/page/html.hpp"
#include "touchstone/examples/program/options/shell_text.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

std::size_t index_in(const PairSet& set, const std::string& id) {
  const auto found = std::find(set.ids.begin(), set.ids.end(), id);
  if (found == set.ids.end())
    throw InputError("site: " + set.name + " has no case '" + id + "': the results are of other pairs");
  return static_cast<std::size_t>(found - set.ids.begin());
}

PairStatus status_named(const std::string& name) {
  for (int i = 0; i <= static_cast<int>(PairStatus::unsupported); ++i)
    if (name == to_string(static_cast<PairStatus>(i))) return static_cast<PairStatus>(i);
  return PairStatus::failed;
}

std::string normal_text(const Vector3& n) {
  return is_finite(n) ? fmt::format("{:.4f} {:.4f} {:.4f}", n.x(), n.y(), n.z()) : "-";
}

std::string distance_text(double separation) {
  return std::isnan(separation) ? "-" : fmt::format("{:.9g}", separation);
}

/// One set's wrong cells and their pairs.
class SetPage {
 public:
  SetPage(const Corpus& corpus, const CorpusSet& set, const Oracle& oracle)
      : corpus_(corpus), pairs_(corpus_pairs(corpus, set)), oracle_(oracle) {}

  /// Adds a wrong cell to the page, and its reproduction to the files.
  void add(const Entry& entry, QueryKind query, const Cell& cell, std::vector<ReportFile>& files) {
    const std::string name = cell_name(entry, pairs_.name, query);
    const std::vector<FiledAnswer> wrong = faults(cell);
    const PairSet first = one_case(pairs_, index_in(pairs_, wrong.front().id));
    files.emplace_back("reproductions/" + name + ".json", pair_file_text(first));
    files.emplace_back("reproductions/" + name + ".md", reproduction_text(entry, query, wrong.front(), first,
                                                                          truth_of(first), name + ".json"));
    body_ += fmt::format("<section id='{0}'><h2>{1}, {2}: {3}</h2>\n<p>{4}</p>\n", xml_text(name),
                         xml_text(entry.engine), to_string(query), xml_text(text_of(cell)),
                         xml_text(entry.description));
    body_ += fmt::format(
        "<p>The dearest one to be filed upstream: <a href='../reproductions/{0}.md'>text</a>, "
        "<a href='../reproductions/{0}.json'>pair file</a>.</p>\n<div class='gallery'>\n",
        xml_text(name));
    for (const FiledAnswer& each : wrong) body_ += figure(entry, query, each);
    body_ += "</div></section>\n";
  }

  /// The same of a wrong cell of paths.
  void add_paths(const Entry& entry, const CorpusSet& set, std::vector<ReportFile>& files) {
    body_ += path_faults(entry, corpus_, set, pairs_, oracle_, files);
  }

  bool is_empty() const { return body_.empty(); }
  std::string html() const {
    return site_page(pairs_.name + ": wrong answers", "<p>" + xml_text(pairs_.description) + "</p>\n" + body_,
                     "../");
  }

 private:
  PairTruth truth_of(const PairSet& one) const {
    const PosedPair posed = posed_pair(one, 0);
    return oracle_.truth(posed.a, posed.b);
  }

  std::string figure(const Entry& entry, QueryKind query, const FiledAnswer& answer) const {
    // The case as the gallery shows it, with one engine's answer.
    const PairSet one = one_case(pairs_, index_in(pairs_, answer.id));
    GalleryCase shown;
    shown.set = pairs_.name;
    shown.id = answer.id;
    shown.backend = entry.engine;
    shown.query = query;
    shown.reason = answer.reason;
    shown.cost = answer.cost;
    shown.posed = posed_pair(one, 0);
    shown.truth = truth_of(one);
    shown.answers = {{entry.engine, status_named(answer.status), answer.separation, answer.n_AB_W}};
    // The exact answer above the engine's.
    HtmlTable table({"answer", "class", "signed distance [m]", "normal"});
    table.add({"exact", std::string(to_string(shown.truth.pair_class)), distance_text(shown.truth.separation),
               normal_text(shown.truth.n_AB_W) + (shown.truth.normal_unique ? "" : " (one of several)")},
              "exact-row");
    table.add({xml_text(entry.engine), answer.status, distance_text(answer.separation),
               normal_text(answer.n_AB_W)});
    return "<figure>" + wireframe_plot(shown, {entry.engine}, false) +
           fmt::format(
               "<figcaption>{}: {}, {} m ({} S)<br><code>compare_backends --corpus {} --case {}</code>",
               xml_text(answer.id), xml_text(answer.reason), format_error(shown_cost(answer.cost)),
               format_error(shown_cost(answer.cost / shown.posed.scale)),
               xml_text(shell_word(corpus_.folder)), xml_text(shell_word(answer.id))) +
           table.str() + "</figcaption></figure>\n";
  }

  const Corpus& corpus_;
  PairSet pairs_;
  const Oracle& oracle_;
  std::string body_;
};

template <class Visit>
void for_wrong_cells(const std::vector<Entry>& entries, const std::string& set, const Visit& visit) {
  for (const Entry& entry : entries) {
    const auto cells = entry.sets.find(set);
    if (cells == entry.sets.end()) continue;
    for (const QueryKind query : kQueryKinds)
      if (!faults(cells->second[index_of(query)]).empty())
        visit(entry, query, cells->second[index_of(query)]);
  }
}

template <class Visit>
void for_wrong_paths(const std::vector<Entry>& entries, const std::string& set, const Visit& visit) {
  for (const Entry& entry : entries) {
    const auto cell = entry.paths.find(set);
    if (cell != entry.paths.end() && !faults(cell->second).empty()) visit(entry);
  }
}

}  // namespace

std::vector<std::string> case_names(const std::vector<Entry>& entries, const Corpus& corpus) {
  std::vector<std::string> names;
  for (const CorpusSet& set : corpus.sets) {
    const std::size_t before = names.size();
    const auto add = [&](const std::string& cell) {
      names.insert(names.end(), {"reproductions/" + cell + ".json", "reproductions/" + cell + ".md"});
    };
    for_wrong_cells(entries, set.name, [&](const Entry& entry, QueryKind query, const Cell&) {
      add(cell_name(entry, set.name, query));
    });
    for_wrong_paths(entries, set.name, [&](const Entry& entry) { add(path_cell_name(entry, set.name)); });
    if (names.size() > before) names.push_back("cases/" + set.name + ".html");
  }
  return names;
}

std::vector<ReportFile> case_files(const std::vector<Entry>& entries, const Corpus& corpus,
                                   const Oracle& oracle) {
  std::vector<ReportFile> files;
  for (const CorpusSet& set : corpus.sets) {
    SetPage page(corpus, set, oracle);
    for_wrong_cells(entries, set.name, [&](const Entry& entry, QueryKind query, const Cell& cell) {
      page.add(entry, query, cell, files);
    });
    for_wrong_paths(entries, set.name, [&](const Entry& entry) { page.add_paths(entry, set, files); });
    if (!page.is_empty()) files.emplace_back("cases/" + set.name + ".html", page.html());
  }
  return files;
}

std::string site_page(const std::string& title, const std::string& body, const std::string& root) {
  return fmt::format(
             "<!doctype html>\n<html lang='en'>\n<head><meta charset='utf-8'><title>{0}</title>\n"
             "<meta name='viewport' content='width=device-width,initial-scale=1'>\n<style>\n",
             xml_text(title)) +
         std::string(embedded_text("report.css")) + plot_style() + std::string(site_text("site.css")) +
         "</style></head>\n<body class='site'>\n<main>\n" +
         (root.empty() ? "" : "<p><a href='" + root + "index.html'>touchstone-bench</a></p>\n") + "<h1>" +
         xml_text(title) + "</h1>\n" + body + "</main>\n</body></html>\n";
}

}  // namespace touchstone::comparison
