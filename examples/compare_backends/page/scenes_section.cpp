#include <fmt/format.h>

#include "touchstone/examples/compare_backends/page/sections.hpp"
#include "touchstone/examples/compare_backends/svg_plot.hpp"
#include "touchstone/examples/compare_backends/timeline_plot.hpp"
#include "touchstone/examples/compare_backends/upper_bound.hpp"
#include "touchstone/examples/program/text_table.hpp"

namespace touchstone::comparison {
namespace {

std::string parameters(const SceneResult& scene) {
  std::string text;
  for (const auto& [name, value] : scene.parameters)
    text += fmt::format("{}{} = {}", text.empty() ? " Parameters: " : ", ", xml_text(name), value);
  return text.empty() ? "" : text + ".";
}

std::string least_that_serves(const SceneResult& scene, QueryKind query) {
  const FacetRow* least = cheapest_row(scene, query);
  if (least == nullptr)
    return fmt::format("<p class='gap'>Nothing serves {} within that.</p>\n", to_string(query));
  const std::string what = fmt::format("{} with {} facets, {} ns a frame", xml_text(least->backend),
                                       least->facets, format_ns(least->frame_ns));
  const std::string thin = thin_evidence(scene, query);
  return thin.empty()
             ? fmt::format("<p>Least that serves {}: <strong>{}</strong>.</p>\n", to_string(query), what)
             : fmt::format("<p>Least that served {} in these frames: {}. No recommendation: {}.</p>\n",
                           to_string(query), what, thin);
}

std::string facets(const Page& page, const SceneResult& scene) {
  if (scene.facet_rows.empty()) {
    return scene.parameters.count("facets") > 0
               ? ""
               : "<p class='soft'>No parameter <code>facets</code>: nothing round, no facet count to "
                 "choose.</p>\n";
  }
  std::string html = fmt::format(
      "<p>Cost against error by facet count, over {} of {} frames, {} of them one after the other around the "
      "{} of the commanded motion, against the exact clearance at {} facets; allowed: {} m. With an error "
      "beyond that in none of them, it is in fewer than {:.2g} % of frames drawn as these were (95 % bound). "
      "In {} of them {} and {} facets differ in class.</p>\n",
      scene.facet_frames, scene.all_frames, scene.facet_frames_near,
      scene.exact_first_contact ? "first contact" : "least clearance", scene.finest_facets,
      format_error(scene.facet_budget), 100 * upper_bound_95(0, scene.facet_frames), scene.facet_class_frames,
      scene.facet_rows.front().facets, scene.finest_facets);
  for (const QueryKind query : kQueryKinds) html += least_that_serves(scene, query);
  HtmlTable table({"backend", "query", "facets", "pairs", "ns a frame", "error [m]", "serves"});
  for (const FacetRow& row : scene.facet_rows) {
    table.add({page.named(row.backend), std::string(to_string(row.query)), std::to_string(row.facets),
               format_count(row.pairs), row.wrong ? "no speed" : format_ns(row.frame_ns),
               format_error(row.error), row.serves ? "yes" : "no"});
  }
  return html + "<details><summary>All rows</summary>" + table.str() + "</details>\n";
}

// A wrong or missing answer in the scene leaves no speed, but its count.
std::string frame_time(const BackendResult& backend, QueryKind query) {
  const std::size_t q = index_of(query);
  const Wrongness& wrong = backend.judgement.wrongness[q];
  if (!backend.judged || wrong.total() == 0) return format_ns(median(backend.frame[q]));
  return wrong.unsupported == wrong.cases ? "unsupported" : "no speed: " + wrong_words(wrong);
}

std::string one_scene(const Page& page, const SceneResult& scene) {
  std::string html = fmt::format(
      "<section><h3>{}</h3><p class='soft'>{} {} of {} frames at {} Hz, {} pairs each; first contact of the "
      "commanded "
      "motion: {}.{}</p>\n",
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
  return html + table.str() + facets(page, scene) + "</section>\n";
}

}  // namespace

std::string scenes_section(const Page& page) {
  if (page.report.scenes.empty()) return "";
  std::string html = R"(<h2>What it costs the task</h2>
<p>Every scene's commanded motion, frame by frame, each backend asked about the commanded poses alone. Bands: empty, free;
full, blocked and rightly so; low, wrongly blocked (contact reported, or not decided, where there is none); high and
crossed, merged (contact not seen, so the frame is shown). Clearance at the stop: the exact clearance of the last frame before
the first that it blocks.</p>
<p class='gap'>Missing: frames after a stop, as a world that holds the objects shows them. <code>training_run --scene FILE
--backend NAME</code> flies the scenes through the contact world and judges every shown frame.</p>
)";
  html += "<div class='scenes'>\n";
  for (const SceneResult& scene : page.report.scenes) html += one_scene(page, scene);
  return html + "</div>\n" + source_note("scenes", "figures/scene_<name>.svg");
}

}  // namespace touchstone::comparison
