#include "examples/compare_backends/html_report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "examples/compare_backends/growth_plot.hpp"
#include "examples/compare_backends/method_text.hpp"
#include "examples/compare_backends/svg_plot.hpp"
#include "examples/program/text_table.hpp"

namespace touchstone::comparison {
namespace {

// ---- pieces of a page

class HtmlTable {
 public:
  explicit HtmlTable(const std::vector<std::string>& header, const char* style = "") {
    html_ = std::string("<div class='scroll'><table class='") + style + "'><thead><tr>";
    for (const std::string& cell : header) html_ += "<th>" + cell + "</th>";
    html_ += "</tr></thead><tbody>\n";
  }
  /// The first cell is markup (a mark and a name), the others are text.
  void add(const std::vector<std::string>& row) {
    html_ += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i) {
      html_ += i == 0 ? "<th>" + row[i] + "</th>" : "<td>" + xml_text(row[i]) + "</td>";
    }
    html_ += "</tr>\n";
  }
  std::string str() const { return html_ + "</tbody></table></div>\n"; }

 private:
  std::string html_;
};

std::string page_style() {
  return R"(:root{color-scheme:light dark;--ink:#1b1f24;--soft:#5b6470;--line:#d5dae0;--paper:#fff;--tint:#f1f4f8;--bad:#a5370a}
@media (prefers-color-scheme:dark){:root{--ink:#e8eaed;--soft:#a3abb5;--line:#3a414a;--paper:#14171a;--tint:#1d2126;--bad:#ff9a61}}
@media print{:root{--ink:#000;--soft:#444;--line:#ccc;--paper:#fff;--tint:#fff}}
body{margin:0 auto;padding:28px 24px 60px;max-width:1240px;background:var(--paper);color:var(--ink);
font:15px/1.5 system-ui,sans-serif}
h1{font-size:26px;margin:0 0 4px}h2{font-size:19px;margin:38px 0 6px;border-top:1px solid var(--line);padding-top:18px}
h3{font-size:15px;margin:22px 0 4px}p{margin:6px 0;max-width:78ch}.soft{color:var(--soft)}
.verdict{background:var(--tint);border-left:4px solid #0072b2;padding:12px 16px;margin:16px 0}
.verdict strong{font-size:17px}.plots{display:grid;grid-template-columns:repeat(auto-fill,minmax(500px,1fr));gap:14px 20px}
.plots svg{width:100%;height:auto}.key{vertical-align:-3px;margin-right:6px}
.legend span{display:inline-block;margin:0 18px 4px 0}.scroll{overflow-x:auto}
table{border-collapse:collapse;font-variant-numeric:tabular-nums;font-size:13px;margin:6px 0 10px}
td,th{padding:3px 9px;text-align:right;border-bottom:1px solid var(--line);white-space:nowrap;font-weight:400}
thead th{color:var(--soft)}th:first-child{text-align:left}code{background:var(--tint);padding:1px 4px;font-size:13px}
.ranks{display:grid;grid-template-columns:repeat(auto-fit,minmax(350px,1fr));gap:0 28px;align-items:start}.ranks table{width:100%}
.wrong{color:var(--bad);white-space:normal}.ranks .wrong{font-size:12px;line-height:1.35}.n{white-space:nowrap}.right{color:var(--soft)}
.matrix td,.matrix thead th{padding:3px 6px;font-size:11.5px;line-height:1.3;text-align:center;vertical-align:middle}
.errors td{white-space:normal;min-width:62px}.matrix{width:100%}.matrix td{border-left:1px solid var(--line)}.matrix thead th:first-child{text-align:left}.w2{background:color-mix(in srgb,var(--bad) 9%,transparent)}.w3{background:color-mix(in srgb,var(--bad) 20%,transparent)}
.gap{color:var(--bad)}dl{display:grid;grid-template-columns:max-content 1fr;gap:3px 18px;margin:8px 0}dt{font-weight:600}dd{margin:0}
@page{size:A4 landscape;margin:11mm}
@media print{.plots>*,.ranks>*,tr{break-inside:avoid}.scroll{overflow:visible}
body{padding:0;max-width:none;font-size:11px}td,th{padding:2px 4px;font-size:8.5px;white-space:normal}h2,h3{break-after:avoid}.plots{grid-template-columns:1fr 1fr}details>summary{display:none}}
)";
}

double median(const std::optional<Timing>& timing) {
  return timing ? timing->median_ns : std::numeric_limits<double>::quiet_NaN();
}

class Page {
 public:
  explicit Page(const Report& report) : report_(report) {
    for (const auto& backend : report.backends) names_.push_back(backend.first);
  }

  std::string str() const {
    std::string html =
        "<!doctype html>\n<html lang='en'><head><meta charset='utf-8'><title>Contact detection backends "
        "compared</title>\n<meta name='viewport' content='width=device-width'><style>\n" +
        page_style() + plot_style() + "</style></head><body>\n";
    html += head() + verdicts() + rankings() + figures() + matrices() + sets() + scenes() + broadphases() +
            pair_file() + method();
    return html + "</body></html>\n";
  }

 private:
  std::string named(const std::string& backend) const {
    return mark_svg(names_, backend) + xml_text(backend);
  }

  std::string head() const {
    const Machine& machine = report_.machine;
    std::string html = "<h1>Contact detection backends: speed against error</h1>\n";
    html +=
        fmt::format("<p class='soft'>{}, {}; {}, {}. Seed {}. <code>{}</code></p>\n", xml_text(machine.cpu),
                    xml_text(machine.system), xml_text(machine.compiler), xml_text(machine.build_type),
                    report_.options.seed, xml_text(report_.options.command_line));
    html += "<p class='legend'>";
    for (const auto& [name, description] : report_.backends) {
      html += fmt::format("<span title='{}'>{}</span>", xml_text(description), named(name));
    }
    html += "</p>\n";
    for (const Gap& gap : report_.gaps) {
      html += fmt::format("<p class='gap'>Missing: {}. {}.</p>\n", xml_text(gap.what), xml_text(gap.why));
    }
    if (!report_.has_truth) {
      html +=
          "<p class='gap'>Without <code>exact</code> no error is measured: this report holds times "
          "only.</p>\n";
    }
    return html;
  }

  std::string verdicts() const {
    std::string html;
    for (const Verdict& verdict : report_.verdicts) {
      const bool asked = verdict.query == report_.options.query;
      html += fmt::format("<div class='verdict'>{0}{1}{2}", asked ? "<strong>" : "",
                          xml_text(sentence(verdict)), asked ? "</strong>" : "");
      HtmlTable table({"backend", "inside", "ns a pair", "worst [m]", "why", "case"});
      for (const Candidate& candidate : verdict.candidates) {
        table.add({named(candidate.backend), candidate.inside ? "yes" : "no",
                   format_ns(candidate.nanoseconds), format_error(candidate.worst_cost),
                   candidate.worst_reason, candidate.worst_id});
      }
      html +=
          (asked ? table.str() : "<details><summary>Why</summary>" + table.str() + "</details>") + "</div>\n";
    }
    return html;
  }

  std::string rankings() const {
    if (report_.rankings.empty()) return "";
    std::string html = fmt::format(
        "<h2>In short</h2>\n<p>Over {} pair {}: the mean of the medians, one pair a call through the "
        "interface, and the worst error over S. A backend with any wrong or missing answer has no place; its "
        "row "
        "says what it got wrong.</p>\n<div class='ranks'>\n",
        report_.sets.size(), report_.sets.size() == 1 ? "set" : "sets");
    for (const Ranking& ranking : report_.rankings) {
      html += fmt::format(
          "<div><h3>{}</h3><table><thead><tr><th>backend</th><th>ns a pair</th><th>worst "
          "error</th></tr></thead><tbody>\n",
          to_string(ranking.query));
      for (const Standing& standing : ranking.standings) {
        html += "<tr><th>" + named(standing.backend) + "</th>";
        html +=
            standing.wrongness.total() == 0
                ? fmt::format("<td>{}</td><td>{}</td></tr>\n", format_ns(standing.nanoseconds),
                              format_error(standing.worst_error))
                : "<td class='wrong' colspan='2'>" + wrong_lines(standing.wrongness, ", ") + "</td></tr>\n";
      }
      html += "</tbody></table></div>\n";
    }
    return html + "</div>\n";
  }

  static std::string wrong_lines(const Wrongness& wrong, const char* between) {
    std::string text;
    const auto add = [&](std::size_t count, const char* what) {
      if (count > 0)
        text += fmt::format("{}<span class='n'>{} {}</span>", text.empty() ? "" : between,
                            format_count(count), what);
    };
    add(wrong.missed, "missed");
    add(wrong.phantom, "phantom");
    add(wrong.undecided, "undecided");
    add(wrong.failed, "failed");
    add(wrong.unsupported, "unsupported");
    add(wrong.missing, "no value");
    return text;
  }

  // Backend by family: how many answers were wrong or missing, and in which way.
  std::string matrices() const {
    if (!report_.has_truth || report_.sets.empty()) return "";
    std::string html = fmt::format(
        "<h2>Wrong answers</h2>\n<p>Of the pairs in each set. <em>Missed</em>: reported apart, yet in "
        "contact. "
        "<em>Phantom</em>: reported in contact, yet apart. <em>No value</em>: the class is right, a figure "
        "that was "
        "asked for is missing. A dot: none.</p>\n");
    for (const QueryKind query : kQueryKinds) html += matrix(query);
    return html;
  }

  std::string matrix(QueryKind query) const {
    std::string html =
        fmt::format("<table class='matrix'><thead><tr><th>{}</th><th>pairs</th>", to_string(query));
    for (const std::string& name : names_) html += "<th>" + named(name) + "</th>";
    html += "</tr></thead><tbody>\n";
    for (const SetResult& set : report_.sets) {
      html += fmt::format("<tr><th>{}</th><td>{}</td>", xml_text(set.name), format_count(set.cases));
      for (const std::string& name : names_) html += matrix_cell(set, name, query);
      html += "</tr>\n";
    }
    return html + "</tbody></table>\n";
  }

  static std::string matrix_cell(const SetResult& set, const std::string& name, QueryKind query) {
    for (const BackendResult& backend : set.backends) {
      if (backend.name != name || !backend.judged) continue;
      const Wrongness& wrong = backend.judgement.wrongness[index_of(query)];
      if (wrong.total() == 0) return "<td class='right'>·</td>";
      const double share = static_cast<double>(wrong.total()) / static_cast<double>(wrong.cases);
      return fmt::format("<td class='wrong w{}'>{}</td>",
                         share < 0.01  ? 1
                         : share < 0.2 ? 2
                                       : 3,
                         wrong_lines(wrong, "<br>"));
    }
    return "<td>-</td>";
  }

  std::string figures() const {
    if (!report_.has_truth || report_.sets.empty()) return "";
    const PlotAxes axes = axes_for(report_.sets);
    std::string html =
        "<h2>Speed against error</h2>\n<p>One mark a backend: its worst error over S, with a whisker to the "
        "median, and its median time, one pair a call through the interface, with a whisker to the 99th "
        "percentile. The column on the left is exactly 0. A backend with any wrong or missing answer gets no "
        "speed mark: it stands hollow on the rail. The dashed line joins the backends that none beats in "
        "both: "
        "above it and right of it something is faster and more exact.</p>\n";
    for (const QueryKind query : kQueryKinds) {
      html += fmt::format("<h3>{}</h3><div class='plots'>\n", to_string(query));
      for (const SetResult& set : report_.sets) html += speed_error_plot(set, query, axes, names_, false);
      html += "</div>\n";
    }
    return html;
  }

  std::string sets() const {
    std::string html = report_.sets.empty() ? "" : "<h2>Pair families</h2>\n";
    for (const SetResult& set : report_.sets) html += one_set(set);
    return html;
  }

  std::string one_set(const SetResult& set) const {
    std::string html = fmt::format("<h3>{}</h3><p class='soft'>{}. {} pairs", xml_text(set.name),
                                   xml_text(set.description), format_count(set.cases));
    if (report_.has_truth) {
      html += fmt::format(", {} in contact, {} of them exactly touching", format_count(set.contacts),
                          format_count(set.touching));
    }
    html += ".</p>\n" + times(set);
    return report_.has_truth ? html + wrongness(set) + errors(set) : html;
  }

  std::string times(const SetResult& set) const {
    HtmlTable table({"median ns a pair", "overlap", "99%", "batch", "raw", "distance", "99%", "batch", "raw",
                     "manifold", "99%", "batch", "raw", "allocations"});
    for (const BackendResult& backend : set.backends) {
      std::vector<std::string> row = {named(backend.name)};
      std::optional<double> allocations;
      for (const BackendResult::Rows& rows : backend.rows) {
        row.push_back(format_ns(median(rows.single)));
        row.push_back(rows.single ? format_ns(rows.single->p99_ns) : "-");
        row.push_back(format_ns(median(rows.batch)));
        row.push_back(format_ns(median(rows.raw)));
        if (rows.allocations) allocations = std::max(allocations.value_or(0.0), *rows.allocations);
      }
      row.push_back(allocations ? fmt::format("{:.3g}", *allocations) : "-");
      table.add(row);
    }
    return table.str();
  }

  std::string wrongness(const SetResult& set) const {
    HtmlTable table({"wrong answers", "query", "missed", "phantom", "undecided", "failed", "unsupported",
                     "no value", "worst cost [m]", "why", "case"});
    for (const BackendResult& backend : set.backends) {
      if (!backend.judged) continue;
      for (const QueryKind kind : kQueryKinds) {
        const Wrongness& wrong = backend.judgement.wrongness[index_of(kind)];
        if (wrong.total() == 0) continue;
        const WorstCase& worst = backend.judgement.worst[index_of(kind)];
        table.add({named(backend.name), std::string(to_string(kind)), format_count(wrong.missed),
                   format_count(wrong.phantom), format_count(wrong.undecided), format_count(wrong.failed),
                   format_count(wrong.unsupported), format_count(wrong.missing), format_error(worst.cost),
                   worst.reason, case_id(set, worst.index)});
      }
    }
    return table.str();
  }

  std::string errors(const SetResult& set) const {
    std::vector<std::string> header = {"errors over S: median / 99% / worst"};
    for (std::size_t m = 0; m < kMeasures; ++m) header.emplace_back(to_string(static_cast<Measure>(m)));
    HtmlTable table(header, "errors");
    for (const BackendResult& backend : set.backends) {
      if (!backend.judged) continue;
      std::vector<std::string> row = {named(backend.name)};
      for (const ErrorStats& stats : backend.judgement.errors) {
        const Quantiles& each = stats.over_scale;
        row.push_back(each.count == 0 ? "-"
                                      : fmt::format("{} / {} / {}", format_error(each.median),
                                                    format_error(each.p99), format_error(each.worst)));
      }
      table.add(row);
    }
    return table.str();
  }

  std::string scenes() const {
    std::string html = report_.scenes.empty() ? "" : "<h2>Scenes</h2>\n";
    for (const SceneResult& scene : report_.scenes) html += one_scene(scene);
    return html;
  }

  std::string one_scene(const SceneResult& scene) const {
    std::string html = fmt::format(
        "<h3>{}</h3><p class='soft'>{} {} of {} frames at {} Hz, {} pairs each; first contact of the "
        "commanded "
        "motion: {}.{}</p>\n",
        xml_text(scene.name), xml_text(scene.description), format_count(scene.frames),
        format_count(scene.all_frames), scene.rate, scene.pairs,
        scene.exact_first_contact ? fmt::format("{:.4f} s", *scene.exact_first_contact) : "none",
        parameters(scene));
    HtmlTable table({"backend", "overlap, ns a frame", "distance", "manifold", "first contact [s]",
                     "missed frames", "phantom frames", "undecided frames", "worst clearance error [m]"});
    for (std::size_t b = 0; b < scene.backends.size(); ++b) {
      const SceneBackend& backend = scene.backends[b];
      const auto& frame = scene.set.backends[b].frame;
      table.add({named(backend.name), format_ns(median(frame[0])), format_ns(median(frame[1])),
                 format_ns(median(frame[2])),
                 backend.first_contact ? fmt::format("{:.4f}", *backend.first_contact) : "-",
                 format_count(backend.missed_frames), format_count(backend.phantom_frames),
                 format_count(backend.undecided_frames), format_error(backend.worst_clearance_error)});
    }
    return html + table.str() + facets(scene);
  }

  static std::string parameters(const SceneResult& scene) {
    std::string text;
    for (const auto& [name, value] : scene.parameters)
      text += fmt::format("{}{} = {}", text.empty() ? " Parameters: " : ", ", xml_text(name), value);
    return text.empty() ? "" : text + ".";
  }

  std::string facets(const SceneResult& scene) const {
    if (scene.facet_rows.empty()) {
      return scene.parameters.count("facets") > 0
                 ? ""
                 : "<p class='soft'>No parameter <code>facets</code>: nothing round, no facet count to "
                   "choose.</p>\n";
    }
    std::string html = fmt::format(
        "<p>Cost against error by facet count, over {} frames, against the exact clearance at {} "
        "facets; allowed: {} m.</p>\n",
        scene.facet_frames, scene.finest_facets, format_error(scene.facet_budget));
    for (const QueryKind query : kQueryKinds) {
      const FacetRow* least = cheapest_row(scene, query);
      html += least
                  ? fmt::format(
                        "<p>Least that serves {}: <strong>{} with {} facets, {} ns a frame</strong>.</p>\n",
                        to_string(query), xml_text(least->backend), least->facets, format_ns(least->frame_ns))
                  : fmt::format("<p class='gap'>Nothing serves {} within that.</p>\n", to_string(query));
    }
    HtmlTable table({"backend", "query", "facets", "pairs", "ns a frame", "error [m]", "serves"});
    for (const FacetRow& row : scene.facet_rows) {
      table.add({named(row.backend), std::string(to_string(row.query)), std::to_string(row.facets),
                 format_count(row.pairs), format_ns(row.frame_ns), format_error(row.error),
                 row.serves ? "yes" : "no"});
    }
    return html + "<details><summary>All rows</summary>" + table.str() + "</details>\n";
  }

  std::string broadphases() const {
    if (report_.broadphases.empty()) return "";
    HtmlTable table({"broadphase", "objects", "hexahedra each", "ms a frame", "99%", "with overlap",
                     "candidates", "allocations a frame", "missed"});
    for (const BroadphaseResult& result : report_.broadphases) {
      if (!result.gap.empty()) {
        table.add({xml_text(result.name), format_count(result.size.objects),
                   format_count(result.size.hexahedra_each), result.gap});
        continue;
      }
      table.add({xml_text(result.name), format_count(result.size.objects),
                 format_count(result.size.hexahedra_each),
                 fmt::format("{:.3f}", result.frame.median_ns * 1e-6),
                 fmt::format("{:.3f}", result.frame.p99_ns * 1e-6),
                 result.with_overlap ? fmt::format("{:.3f}", result.with_overlap->median_ns * 1e-6) : "-",
                 format_count(static_cast<std::size_t>(result.candidates)),
                 result.allocations ? fmt::format("{:.3g}", *result.allocations) : "-",
                 result.missed ? fmt::format("{} of {}", *result.missed, format_count(result.true_pairs))
                               : "not checked"});
    }
    return "<h2>Broadphases</h2>\n<p>update and find_pairs of objects that all move and turn every "
           "frame. Missed: of the pairs whose hexahedra are within the margin in the last frame, taken from "
           "all "
           "pairs "
           "up to 10 000 hexahedra, beyond that from the candidates of all broadphases, confirmed by "
           "<code>exact</code>. With overlap: and the overlap of all pairs by the narrowphase of the same "
           "name, as "
           "one batch.</p>\n" +
           growth_plot(report_.broadphases, Growth::objects, names_, false) +
           growth_plot(report_.broadphases, Growth::hexahedra_each, names_, false) + table.str();
  }

  std::string pair_file() const {
    if (!report_.pair_file) return "";
    std::string html = fmt::format(
        "<h2>Your pairs</h2>\n<p>{} cases of <code>{}</code>; every answer is in answers.json and "
        "answers.csv.</p>\n",
        report_.pair_file->cases.cases.size(), xml_text(report_.pair_file->cases.file));
    for (const PairFileCases::Case& each : report_.pair_file->cases.cases) {
      if (!each.invalid.empty()) {
        html +=
            fmt::format("<p class='gap'>{}: invalid. {}</p>\n", xml_text(each.id), xml_text(each.invalid));
      }
    }
    return html;
  }

  std::string method() const {
    std::string html =
        "<h2>Method</h2>\n<p>S is the larger of the pair's size and its largest world coordinate. Every "
        "error "
        "is measured against <code>exact</code>, which decides in integers.</p>\n<h3>Errors</h3><dl>";
    for (std::size_t m = 0; m < kMeasures; ++m) {
      const auto measure = static_cast<Measure>(m);
      html += fmt::format("<dt>{}</dt><dd>{}</dd>\n", to_string(measure),
                          xml_text(std::string(definition(measure))));
    }
    const MeasureOptions measure;
    html += fmt::format(
        "</dl>\n<h3>Times</h3><p>{} pairs a family, {} repetitions, blocks of {} pairs, batches of "
        "{}.</p><dl>",
        format_count(report_.options.pair_count()), report_.options.repetitions, measure.block,
        format_count(measure.batch));
    for (const auto& [name, text] : kTimingMethod) {
      html += fmt::format("<dt>{}</dt><dd>{}</dd>\n", name, xml_text(std::string(text)));
    }
    html += "</dl>\n<h3>Backends</h3><dl>";
    for (const auto& [name, description] : report_.backends) {
      html += fmt::format("<dt>{}</dt><dd>{}{}</dd>\n", named(name), xml_text(description), declared(name));
    }
    html += fmt::format("</dl>\n<p class='soft'>Touchstone {}, compiled with {}.{}</p>\n",
                        xml_text(report_.machine.version), xml_text(report_.machine.flags), libraries());
    return html +
           "<p>A case is replayed with <code>compare_backends --case ID</code>. The same figures: "
           "results.json, "
           "results.csv; each plot: figures/.</p>\n";
  }

  std::string libraries() const {
    std::string text;
    for (const auto& [name, version] : report_.machine.libraries)
      text += fmt::format(" {}: {}.", xml_text(name), xml_text(version));
    return text;
  }

  std::string declared(const std::string& backend) const {
    for (const SetResult& set : report_.sets) {
      for (const BackendResult& result : set.backends) {
        if (result.name != backend) continue;
        return fmt::format(" ({} bits; declares {} m + {} of the scale)", result.capabilities.scalar_bits,
                           format_error(result.capabilities.resolution.absolute),
                           format_error(result.capabilities.resolution.relative));
      }
    }
    return "";
  }

  const Report& report_;
  std::vector<std::string> names_;
};

}  // namespace

std::string html_report(const Report& report) { return Page(report).str(); }

std::vector<ReportFile> figure_files(const Report& report) {
  std::vector<ReportFile> files;
  if (!report.has_truth) return files;
  std::vector<std::string> names;
  for (const auto& backend : report.backends) names.push_back(backend.first);
  const PlotAxes axes = axes_for(report.sets);
  for (const SetResult& set : report.sets) {
    for (const QueryKind query : kQueryKinds) {
      files.emplace_back(fmt::format("figures/{}_{}.svg", set.name, to_string(query)),
                         speed_error_plot(set, query, axes, names, true));
    }
  }
  if (!report.broadphases.empty()) {
    files.emplace_back("figures/broadphases.svg",
                       growth_plot(report.broadphases, Growth::objects, names, true));
    files.emplace_back("figures/broadphases_hexahedra.svg",
                       growth_plot(report.broadphases, Growth::hexahedra_each, names, true));
  }
  return files;
}

}  // namespace touchstone::comparison
