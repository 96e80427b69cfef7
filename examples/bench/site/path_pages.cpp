#include "touchstone/examples/bench/site/path_pages.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/bench/corpus/corpus_writer.hpp"
#include "touchstone/examples/bench/site/reproduction.hpp"
#include "touchstone/examples/bench/site/site_text.hpp"
#include "touchstone/examples/compare_backends/page/html.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

std::string markup(const Entry& entry, const std::string& set) {
  const auto found = entry.paths.find(set);
  if (found == entry.paths.end()) return "<span class='no-cell'>not run</span>";
  const std::string text = xml_text(text_of(found->second));
  if (faults(found->second).empty())
    return fmt::format("<span class='{}'>{}</span>", style_of(grade(found->second)), text);
  return fmt::format("<a class='wrong-cell' href='cases/{}.html#{}'>{}</a>", xml_text(set),
                     xml_text(path_cell_name(entry, set)), text);
}

std::size_t wrong_of(const Entry& entry) {
  std::size_t wrong = 0;
  for (const auto& [name, cell] : entry.paths) wrong += cell.wrong() + cell.open;
  return wrong;
}

std::string check_of(const Entry& entry) {
  for (const auto& [name, cell] : entry.paths)
    if (cell.answered > 0) return cell.check;
  return "-";
}

std::string first_poses(const Entry& entry) {
  std::size_t right = 0, all = 0;
  for (const auto& [name, cell] : entry.paths) {
    right += cell.pose_right;
    all += cell.pose_right + cell.pose_later + cell.pose_earlier + cell.pose_open;
  }
  return all == 0 ? "-" : fmt::format("{} of {}", unbroken_count(right), unbroken_count(all));
}

std::string sets_table(const BenchResults& results) {
  HtmlTable rows({"set", "paths", "poses a path", "meet", "meet between poses alone", "not decided"});
  for (const FiledPathSet& set : results.path_sets)
    rows.add({xml_text(set.name), format_count(set.paths), format_count(set.poses), format_count(set.meets),
              format_count(set.unseen), format_count(set.open)});
  return rows.str();
}

std::size_t path_index(const PairSet& pairs, std::size_t poses, const std::string& id) {
  for (std::size_t i = 0; i * poses < pairs.pairs.size(); ++i)
    if (paths_of(pairs, poses, i).id == id) return i;
  throw InputError("site: " + pairs.name + " has no path '" + id + "': the results are of other paths");
}

std::string truth_text(const PathTruth& truth) {
  return truth.path_class == PathClass::meets ? fmt::format("meets at s in [{}, {}]", truth.lo, truth.hi)
                                              : std::string(to_string(truth.path_class));
}

/// The path's ends, and where the two touch first.
PairSet reproduced(const PairSet& pairs, std::size_t poses, std::size_t index, const PathTruth& truth) {
  const SolidPaths paths = paths_of(pairs, poses, index);
  PairSet out;
  out.name = pairs.name;
  const auto add = [&](double s, const std::string& name) {
    const auto first = static_cast<SolidIndex>(out.solids.size());
    out.solids.insert(out.solids.end(), paths.solids.begin(), paths.solids.end());
    for (const RigidPath& way : paths.ways) out.poses.push_back(way.pose_at(s));
    out.pairs.push_back({first, first + 1});
    out.ids.push_back(paths.id + "@" + name);
  };
  add(0, "start");
  add(1, "end");
  if (truth.path_class == PathClass::meets) add(truth.hi, "contact");
  return out;
}

std::string how_asked(const PathCell& cell) {
  return cell.check == "swept" ? "the engine's own sweep"
                               : cell.check + " advancement on the engine's answers at poses";
}

}  // namespace

Grade grade(const PathCell& cell) {
  if (cell.answered == 0) return Grade::not_answered;
  if (cell.wrong() > 0 || cell.worst.cost_over_scale >= kFar) return Grade::wrong;
  return cell.open > 0 || cell.worst.cost_over_scale >= kCoarse ? Grade::coarse : Grade::right;
}

std::string text_of(const PathCell& cell) {
  if (cell.answered == 0) return "-";
  std::string text;
  const std::pair<std::size_t, const char*> kinds[] = {{cell.missed, "missed"},   {cell.late, "late"},
                                                       {cell.phantom, "phantom"}, {cell.early, "early"},
                                                       {cell.failed, "failed"},   {cell.open, "open"}};
  for (const auto& [count, name] : kinds)
    if (count > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", unbroken_count(count), name);
  if (!text.empty()) text += fmt::format(" of {}; ", unbroken_count(cell.answered));
  text += fmt::format("{:.0e} S", cell.worst.cost_over_scale);
  if (cell.unsupported > 0) text += fmt::format(", {} not taken", unbroken_count(cell.unsupported));
  return text;
}

std::vector<FiledPath> faults(const PathCell& cell) {
  if (grade(cell) != Grade::wrong) return {};
  std::vector<FiledPath> all = cell.wrong_cases;
  if (all.empty() || (cell.worst.cost_over_scale >= kFar && all.front().id != cell.worst.id))
    all.insert(all.begin(), cell.worst);
  return all;
}

std::string path_cell_name(const Entry& entry, const std::string& set) {
  return fmt::format("{}_{}_path", set, entry.engine);
}

std::string path_section(const BenchResults& results, const std::vector<Entry>& newest) {
  if (results.path_sets.empty()) return "";
  // A column a set.
  std::vector<std::string> header = {"engine", "wrong, open or early", "check",
                                     "first pose in contact is right"};
  for (const FiledPathSet& set : results.path_sets) header.push_back(set.name);
  HtmlTable rows(header);
  // A row an engine, the fewest wrong first.
  std::vector<const Entry*> order;
  for (const Entry& entry : newest)
    if (!entry.paths.empty()) order.push_back(&entry);
  std::stable_sort(order.begin(), order.end(),
                   [](const Entry* x, const Entry* y) { return wrong_of(*x) < wrong_of(*y); });
  for (const Entry* entry : order) {
    std::vector<std::string> row = {
        fmt::format("<span title='{}'>{}</span>", xml_text(entry->description), xml_text(entry->engine)),
        format_count(wrong_of(*entry)), xml_text(check_of(*entry)), first_poses(*entry)};
    for (const FiledPathSet& set : results.path_sets) row.push_back(markup(*entry, set.name));
    rows.add_markup(row);
  }
  return "<section id='paths'><h2>Paths</h2>\n<p>Where two moving solids are stopped before they meet: by "
         "conservative advancement on the engine's own separations (proven), by its verdict at poses "
         "(sampled), or by a sweep of the engine's own, under a name of its own (swept). A cell says what "
         "was wrong, then the dearest answer over S: how deep the solids are where they stop, or how far "
         "apart still. A stop that is still 1e-3 S away is early. Sweeps are not asked about paths that turn "
         "further than they follow.</p>\n" +
         rows.str() + sets_table(results) + "</section>\n";
}

std::string path_faults(const Entry& entry, const Corpus& corpus, const CorpusSet& set, const PairSet& pairs,
                        const Oracle& oracle, std::vector<ReportFile>& files) {
  // Every fault, beside what is true.
  const std::vector<PathTruth> truth = corpus_impacts(corpus, set);
  const PathCell& cell = entry.paths.at(set.name);
  const std::vector<FiledPath> wrong = faults(cell);
  const std::string name = path_cell_name(entry, set.name);
  HtmlTable rows({"path", "answer", "truth", "cost [m]"});
  for (const FiledPath& fault : wrong)
    rows.add({xml_text(fault.id), stop_text(fault.s, fault.reason),
              truth_text(truth[path_index(pairs, set.poses, fault.id)]), format_error(fault.cost)});
  // The dearest one as a text and a pair file.
  const std::size_t index = path_index(pairs, set.poses, wrong.front().id);
  const PairSet shown = reproduced(pairs, set.poses, index, truth[index]);
  const double separation =
      oracle.truth(posed_pair(shown, shown.pairs.size() - 1).a, posed_pair(shown, shown.pairs.size() - 1).b)
          .separation;
  files.emplace_back("reproductions/" + name + ".json", pair_file_text(shown));
  files.emplace_back("reproductions/" + name + ".md",
                     filled(site_text("reproduction_path.md"),
                            {{"engine", entry.engine},
                             {"description", entry.description},
                             {"reason", wrong.front().reason.empty() ? "inexact" : wrong.front().reason},
                             {"path", wrong.front().id},
                             {"a", solid_text(shown.solids[0], shown.poses[0])},
                             {"b", solid_text(shown.solids[1], shown.poses[1])},
                             {"to_a", pose_text(shown.poses[2])},
                             {"to_b", pose_text(shown.poses[3])},
                             {"check", how_asked(cell)},
                             {"answer", stop_text(wrong.front().s, wrong.front().reason)},
                             {"truth", truth_text(truth[index])},
                             {"last", shown.ids.back()},
                             {"separation", fmt::format("{}", separation)},
                             {"cost", fmt::format("{:.3g}", wrong.front().cost)},
                             {"file", name + ".json"}}));
  return fmt::format(
      "<section id='{0}'><h2>{1}, paths: {2}</h2>\n<p>{3}</p>\n<p>The dearest one to be filed "
      "upstream: <a href='../reproductions/{0}.md'>text</a>, "
      "<a href='../reproductions/{0}.json'>pair file</a>.</p>\n{4}</section>\n",
      xml_text(name), xml_text(entry.engine), xml_text(text_of(cell)), xml_text(entry.description),
      rows.str());
}

}  // namespace touchstone::comparison
