#include "touchstone/examples/compare_backends/cli/terminal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

// The reference of the ratio columns: native's one-pair-a-call median, else the fastest one's.
double reference(const SetResult& set, QueryKind kind) {
  double fastest = kNaN;
  for (const BackendResult& backend : set.backends) {
    const double ns = median(backend.rows[index_of(kind)].single);
    if (backend.name == "native" && !std::isnan(ns)) return ns;
    fastest = std::fmin(fastest, ns);
  }
  return fastest;
}

// Fits fourteen columns into 120 characters; the files have every digit.
std::string short_ns(double nanoseconds) {
  if (!(nanoseconds >= 9995)) return format_ns(nanoseconds);
  return nanoseconds < 99950 ? fmt::format("{:.1f}k", nanoseconds / 1000)
                             : fmt::format("{:.0f}k", nanoseconds / 1000);
}

std::string timing_table(const SetResult& set) {
  TextTable table({"ns a pair", "overlap", "ratio", "batch", "raw", "dist", "ratio", "batch", "raw", "manif",
                   "ratio", "batch", "raw", "allocs"});
  for (const BackendResult& backend : set.backends) {
    std::vector<std::string> row = {backend.name};
    std::optional<double> allocations;
    for (const QueryKind kind : kQueryKinds) {
      const BackendResult::Rows& rows = backend.rows[index_of(kind)];
      row.push_back(short_ns(median(rows.single)));
      row.push_back(format_ratio(median(rows.single) / reference(set, kind)));
      row.push_back(short_ns(median(rows.batch)));
      row.push_back(short_ns(median(rows.raw)));
      if (rows.allocations) allocations = std::max(allocations.value_or(0), *rows.allocations);
    }
    row.push_back(allocations ? fmt::format("{:.3g}", *allocations) : "-");
    table.add(std::move(row));
  }
  return table.str();
}

std::string wrong_of(const BackendResult& backend, QueryKind kind) {
  return format_count(backend.judgement.wrongness[index_of(kind)].total());
}

const Quantiles& error_of(const BackendResult& backend, Measure measure) {
  return backend.judgement.errors[static_cast<std::size_t>(measure)].over_scale;
}

std::string error_table(const SetResult& set) {
  TextTable table({"wrong; error/S", "miss", "phant", "undec", "overlap", "distance", "manif", "dist",
                   "depth", "normal", "witness", "points", "patch"});
  for (const BackendResult& backend : set.backends) {
    if (!backend.judged) continue;
    const Wrongness& wrong = backend.judgement.wrongness[index_of(QueryKind::overlap)];
    std::vector<std::string> row = {backend.name, format_count(wrong.missed), format_count(wrong.phantom),
                                    format_count(wrong.undecided)};
    for (const QueryKind kind : kQueryKinds) row.push_back(wrong_of(backend, kind));
    for (const Measure measure : {Measure::distance, Measure::depth, Measure::normal, Measure::witness,
                                  Measure::point_witness, Measure::patch_coverage}) {
      row.push_back(format_error(error_of(backend, measure).worst));
    }
    table.add(std::move(row));
  }
  return table.str();
}

std::string set_section(const SetResult& set, bool has_truth) {
  std::string text = fmt::format("\n{}: {}\n", set.name, set.description);
  text += has_truth
              ? fmt::format("  {} pairs, {} in contact ({} exactly touching)\n", format_count(set.cases),
                            format_count(set.contacts), format_count(set.touching))
              : fmt::format("  {} pairs\n", format_count(set.cases));
  text += timing_table(set);
  if (has_truth) text += error_table(set);
  for (const BackendResult& backend : set.backends) {
    if (!backend.failure.empty()) text += fmt::format("  {}: {}\n", backend.name, backend.failure);
  }
  return text;
}

std::string broadphase_section(const Report& report) {
  TextTable table({"broadphase", "objects", "hexahedra each", "ms a frame", "99%", "with overlap",
                   "candidates", "allocs", "missed"});
  bool from_candidates = false;
  for (const BroadphaseResult& result : report.broadphases) {
    from_candidates |= result.from_candidates;
    // A size that was not run says why.
    if (!result.gap.empty()) {
      table.add({result.name, format_count(result.size.objects), format_count(result.size.hexahedra_each),
                 result.gap});
      continue;
    }
    // Figures that were not measured are dashes.
    table.add(
        {result.name, format_count(result.size.objects), format_count(result.size.hexahedra_each),
         fmt::format("{:.3f}", result.frame.median_ns * 1e-6),
         std::isnan(shown_p99(result.frame)) ? "-" : fmt::format("{:.3f}", shown_p99(result.frame) * 1e-6),
         result.with_overlap ? fmt::format("{:.3f}", result.with_overlap->median_ns * 1e-6) : "-",
         format_count(static_cast<std::size_t>(result.candidates)),
         result.allocations ? fmt::format("{:.3g}", *result.allocations) : "-",
         result.missed ? fmt::format("{} of {}", *result.missed, format_count(result.true_pairs))
                       : "not checked"});
  }
  // The legend says how true pairs were found.
  return "\nbroadphases: update and find_pairs of objects that all move; with overlap: and the narrowphase "
         "of that name;\nedge_face: the paper's, which lists every pair in range anew and misses spheres "
         "that touch exactly\n" +
         table.str() +
         (from_candidates ? "  above 10 000 hexahedra the true pairs are those that any of the broadphases "
                            "found, confirmed by exact\n"
                          : "");
}

std::string least_line(const SceneTrade& trade, QueryKind query) {
  const TradeRow* least = cheapest_row(trade, query, trade.allowed);
  if (least == nullptr) return fmt::format("  nothing serves {} within that\n", to_string(query));
  const std::string thin = thin_evidence(trade, query);
  std::string text =
      fmt::format("  least that {} {}: {}, {} ns a frame\n", thin.empty() ? "serves" : "served",
                  to_string(query), words(*least), format_ns(least->frame_ns));
  return thin.empty() ? text : text + "    no recommendation: " + thin + "\n";
}

std::string trade_section(const SceneTrade& trade) {
  if (trade.rows.empty()) return "";
  std::string text =
      fmt::format("  the least that serves, {} frames, {}; allowed {} m\n", trade.frames,
                  trade.round ? "against the true round parts" : "against the scene as written",
                  format_error(trade.allowed));
  for (const QueryKind query : kQueryKinds) text += least_line(trade, query);
  TextTable steps({"by allowed error", "from [m]", "serves", "ns a frame", "geometry [m]", "backend [m]"});
  for (const QueryKind query : kQueryKinds)
    for (const TradeStep& step : trade_steps(trade, query))
      steps.add({std::string(to_string(query)), format_error(step.allowed), words(*step.row),
                 format_ns(step.row->frame_ns), format_error(step.row->geometry_error),
                 format_error(step.row->backend_error)});
  return text + steps.str();
}

std::string selection_section(const std::vector<SelectionRow>& rows) {
  if (rows.empty()) return "";
  TextTable table({"objects", "switched off", "candidates", "us a frame", "least"});
  for (const SelectionRow& row : rows)
    table.add({format_count(row.objects), format_count(row.switched_off), format_ns(row.candidate_pairs),
               format_ns(row.frame.median_ns * 1e-3), format_ns(row.frame.minimum_ns * 1e-3)});
  return "\nselection: a contact world of boxes that all move, some of them switched off\n" + table.str();
}

std::string parameters_text(const SceneResult& scene) {
  std::string text;
  for (const auto& [name, value] : scene.parameters)
    text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", name, value);
  return text.empty() ? "" : "  parameters: " + text + "\n";
}

std::string scene_section(const SceneResult& scene) {
  std::string text =
      fmt::format("\nscene {}: {} of {} frames at {} Hz, {} pairs; first contact {}\n", scene.name,
                  format_count(scene.frames), format_count(scene.all_frames), scene.rate, scene.pairs,
                  scene.exact_first_contact ? fmt::format("at {:.4f} s", *scene.exact_first_contact)
                                            : std::string("none or not measured"));
  text += parameters_text(scene);
  TextTable table({"ns a frame", "overlap", "distance", "manifold", "contact [s]", "missed", "phantom",
                   "undec", "clearance error [m]"});
  for (std::size_t b = 0; b < scene.backends.size(); ++b) {
    const SceneBackend& backend = scene.backends[b];
    const auto& frame = scene.set.backends[b].frame;
    table.add({backend.name, format_ns(median(frame[0])), format_ns(median(frame[1])),
               format_ns(median(frame[2])),
               backend.first_contact ? fmt::format("{:.4f}", *backend.first_contact) : "-",
               format_count(backend.missed_frames), format_count(backend.phantom_frames),
               format_count(backend.undecided_frames), format_error(backend.worst_clearance_error)});
  }
  text += table.str();
  return text + trade_section(scene.trade);
}

std::string pair_file_section(const PairFileResult& result) {
  std::string text = fmt::format("\n{}: {} cases\n", result.cases.file, result.cases.cases.size());
  for (const PairFileCases::Case& each : result.cases.cases) {
    if (!each.invalid.empty()) text += fmt::format("  {}: invalid: {}\n", each.id, each.invalid);
  }
  return text;
}

std::string summary_section(const Report& report) {
  if (report.rankings.empty()) return "";
  std::string text = "\nsummary: mean of the medians over the pair families; worst error over S\n";
  for (const Ranking& ranking : report.rankings) {
    const std::size_t cases = ranking.standings.empty() ? 0 : ranking.standings.front().wrong.cases;
    text += fmt::format("  {}, {} pairs\n", to_string(ranking.query), format_count(cases));
    for (const RankedBackend& standing : ranking.standings) {
      const bool right = standing.wrong.is_complete();
      text += right ? fmt::format("    {:18} {:>9} ns a pair, worst error {}\n", standing.backend,
                                  format_ns(standing.nanoseconds), format_error(standing.worst_error))
                    : fmt::format("    {:18} no place: {}\n", standing.backend, wrong_words(standing.wrong));
    }
  }
  return text;
}

}  // namespace

std::string verdict_text(const Verdict& verdict) {
  std::string text = "\n" + sentence(verdict) + "\n";
  if (verdict.is_empty()) return text;
  TextTable table({"backend", "inside", "ns a pair", "99.9 %", "allocs", "beyond", "worst [m]", "why"});
  for (const Candidate& candidate : verdict.candidates) {
    table.add({candidate.backend, candidate.inside ? "yes" : "no", speed_text(candidate),
               format_ns(candidate.p999_ns), format_allocations(candidate.allocations),
               beyond_text(candidate), format_error(candidate.worst_cost), reason_out(verdict, candidate)});
  }
  return text + table.str() +
         "  ns a pair: of all pairs of these sets; 99.9 %: of single calls, a pair or a scene\'s frame, with "
         "the clock\'s\n  own time; -: too few calls, or not counted\n";
}

namespace {

std::string head_section(const Report& report) {
  std::string text = fmt::format("{} ({}), {}\n{}, {}{}\n", report.machine.cpu,
                                 report.machine.instruction_set, report.machine.system,
                                 report.machine.compiler, report.machine.build_type, report.machine.flags);
  for (const auto& [name, description] : report.backends)
    text += fmt::format("  {:16} {}\n", name, description);
  for (const Gap& gap : report.gaps) text += fmt::format("  {:18}  {}\n", gap.what, gap.why);
  if (!report.has_truth) text += "  without `exact` no error is measured: times only\n";
  return text;
}

}  // namespace

std::string new_tables(const Report& report, Shown& shown) {
  std::string text;
  if (!shown.head) text += head_section(report);
  for (; shown.sets < report.sets.size(); ++shown.sets)
    text += set_section(report.sets[shown.sets], report.has_truth);
  if (report.pair_file && !shown.pair_file) text += pair_file_section(*report.pair_file);
  for (; shown.scenes < report.scenes.size(); ++shown.scenes)
    text += scene_section(report.scenes[shown.scenes]);
  if (!report.broadphases.empty() && !shown.broadphases) text += broadphase_section(report);
  if (!shown.selection) text += selection_section(report.selection);
  shown.head = true;
  shown.pair_file = report.pair_file.has_value();
  shown.broadphases = !report.broadphases.empty();
  shown.selection = !report.selection.empty();
  return text;
}

std::string terminal_report(const Report& report, Shown shown) {
  std::string text = new_tables(report, shown) + summary_section(report);
  for (const Verdict& verdict : report.verdicts) {
    if (verdict.choice.query == report.options.choice.query) text += verdict_text(verdict);
  }
  return text;
}

}  // namespace touchstone::comparison
