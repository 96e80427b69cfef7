#include <fmt/format.h>

#include "touchstone/examples/compare_backends/figures/timeline_plot.hpp"
#include "touchstone/examples/compare_backends/judge/upper_bound.hpp"
#include "touchstone/examples/compare_backends/page/sections.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

std::string parameters(const SceneResult& scene) {
  std::string text;
  for (const auto& [name, value] : scene.parameters)
    text += fmt::format("{}{} = {}", text.empty() ? " Parameters: " : ", ", xml_text(name), value);
  return text.empty() ? "" : text + ".";
}

std::string least_that_serves(const SceneTrade& trade, QueryKind query) {
  const TradeRow* least = cheapest_row(trade, query, trade.allowed);
  if (least == nullptr)
    return fmt::format("<p class='gap'>Nothing serves {} within that.</p>\n", to_string(query));
  const std::string what =
      fmt::format("{}, {} ns a frame", xml_text(words(*least)), format_ns(least->frame_ns));
  const std::string thin = thin_evidence(trade, query);
  return thin.empty()
             ? fmt::format("<p>Least that serves {}: <strong>{}</strong>.</p>\n", to_string(query), what)
             : fmt::format("<p>Least that served {} in these frames: {}. No recommendation: {}.</p>\n",
                           to_string(query), what, thin);
}

std::string evidence(const SceneResult& scene) {
  const SceneTrade& trade = scene.trade;
  const std::string differing = fmt::format(" In {} of them two models differ in class.", trade.class_frames);
  if (trade.all_frames) return fmt::format("every one of {} frames.", trade.frames) + differing;
  return fmt::format(
      "{} of {} frames, {} of them one after the other around the {} of the commanded motion. With an error "
      "beyond that in none of them, it is in fewer than {:.2g} % of frames drawn as these were (95 % "
      "bound).{}",
      trade.frames, scene.all_frames, trade.frames_near,
      scene.exact_first_contact ? "first contact" : "least clearance", 100 * upper_bound_95(0, trade.frames),
      differing);
}

std::string all_rows(const Page& page, const SceneTrade& trade) {
  HtmlTable table({"backend", "query", "model", "hexahedra", "pairs", "ns a frame", "geometry [m]",
                   "backend [m]", "serves"});
  for (const TradeRow& row : trade.rows) {
    const bool serves = row.serves(trade.allowed);
    table.add({page.named(row.backend), std::string(to_string(row.query)), xml_text(row.model),
               format_count(row.hexahedra), format_count(row.pairs),
               row.wrong_frames > 0 && !serves ? "no speed" : format_ns(row.frame_ns),
               format_error(row.geometry_error), format_error(row.backend_error), serves ? "yes" : "no"});
  }
  return "<details><summary>All rows</summary>" + table.str() + "</details>\n";
}

std::string trade_text(const Page& page, const SceneResult& scene) {
  const SceneTrade& trade = scene.trade;
  if (trade.rows.empty()) return "";
  std::string html = fmt::format(
      "<h4>Smallest sufficient model</h4><p>Models of the scene, all pairs or those that the motion needs, "
      "against {}; allowed: {} m, over {}</p>\n",
      trade.round ? "the true round parts" : "the hexahedra as written", format_error(trade.allowed),
      evidence(scene));
  for (const QueryKind query : kQueryKinds) html += least_that_serves(trade, query);
  HtmlTable steps({"query", "from an allowed error of [m]", "the least that serves", "ns a frame",
                   "geometry [m]", "backend [m]"});
  for (const QueryKind query : kQueryKinds)
    for (const TradeStep& step : trade_steps(trade, query))
      steps.add({std::string(to_string(query)), format_error(step.allowed), xml_text(words(*step.row)),
                 format_ns(step.row->frame_ns), format_error(step.row->geometry_error),
                 format_error(step.row->backend_error)});
  return html + steps.str() + all_rows(page, trade);
}

std::string selection_text(const std::vector<SelectionRow>& rows) {
  if (rows.empty()) return "";
  HtmlTable table({"objects", "switched off", "candidate pairs a frame", "us a frame"});
  for (const SelectionRow& row : rows)
    table.add({format_count(row.objects), format_count(row.switched_off), format_ns(row.candidate_pairs),
               format_ns(row.frame.median_ns * 1e-3)});
  return "<h3>Time saved by selection</h3><p>A contact world of boxes that all move and turn, with objects "
         "switched off: what a frame costs.</p>" +
         table.str();
}

// A wrong or missing answer in the scene leaves no speed, but its count.
std::string frame_time(const BackendResult& backend, QueryKind query) {
  const std::size_t q = index_of(query);
  const Wrongness& wrong = backend.judgement.wrongness[q];
  if (!backend.judged || wrong.is_complete()) return format_ns(median(backend.frame[q]));
  return wrong.unsupported == wrong.cases ? "unsupported" : "no speed: " + wrong_words(wrong);
}

std::string one_scene(const Page& page, const SceneResult& scene) {
  std::string html = fmt::format(
      "<section><h3>{}</h3><p class='soft'>{} {} of {} frames at {} Hz, {} pairs each; first contact of the "
      "commanded motion: {}.{}</p>\n",
      xml_text(scene.name), xml_text(scene.description), format_count(scene.frames),
      format_count(scene.all_frames), scene.rate, scene.pairs,
      scene.exact_first_contact ? fmt::format("{:.4f} s", *scene.exact_first_contact) : "none",
      parameters(scene));
  html += timeline_plot(scene, page.names, false);
  HtmlTable table({"backend", "overlap, ns a frame", "distance", "manifold", "first contact [s]", "missed",
                   "phantom", "undecided", "clearance error [m]", "at the stop [m]"});
  for (std::size_t b = 0; b < scene.backends.size(); ++b) {
    const SceneBackend& backend = scene.backends[b];
    const BackendResult& result = scene.set.backends[b];
    table.add({page.named(backend.name), frame_time(result, QueryKind::overlap),
               frame_time(result, QueryKind::distance), frame_time(result, QueryKind::manifold),
               backend.first_contact ? fmt::format("{:.4f}", *backend.first_contact) : "-",
               format_count(backend.missed_frames), format_count(backend.phantom_frames),
               format_count(backend.undecided_frames), format_error(backend.worst_clearance_error),
               format_error(backend.clearance_at_stop)});
  }
  return html + table.str() + trade_text(page, scene) + "</section>\n";
}

}  // namespace

std::string scenes_section(const Page& page) {
  if (page.report.scenes.empty()) return "";
  std::string html = R"(<h2>Cost to the task</h2>
<p>Every scene's commanded motion, frame by frame, each backend asked about the commanded poses alone. Bands: empty, free;
full, blocked and rightly so; low, wrongly blocked (contact reported, or not decided, where there is none); high and
crossed, merged (contact not seen, so the frame is shown). Clearance at the stop: the exact clearance of the last frame before
the first that it blocks.</p>
<p class='gap'>Missing: frames after a stop, as a world that holds the objects shows them. <code>training_run --scene FILE
--backend NAME</code> flies the scenes through the contact world and judges every shown frame.</p>
)";
  html += "<div class='scenes'>\n";
  for (const SceneResult& scene : page.report.scenes) html += one_scene(page, scene);
  html += "</div>\n" + selection_text(page.report.selection);
  return html + source_note("scenes", "figures/scene_<name>.svg");
}

}  // namespace touchstone::comparison
