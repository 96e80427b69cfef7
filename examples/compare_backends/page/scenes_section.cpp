#include <fmt/format.h>

#include "examples/compare_backends/page/sections.hpp"
#include "examples/compare_backends/svg_plot.hpp"
#include "examples/compare_backends/timeline_plot.hpp"
#include "examples/program/text_table.hpp"

namespace touchstone::comparison {
namespace {

std::string parameters(const SceneResult& scene) {
  std::string text;
  for (const auto& [name, value] : scene.parameters)
    text += fmt::format("{}{} = {}", text.empty() ? " Parameters: " : ", ", xml_text(name), value);
  return text.empty() ? "" : text + ".";
}

std::string facets(const Page& page, const SceneResult& scene) {
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
    html += least ? fmt::format(
                        "<p>Least that serves {}: <strong>{} with {} facets, {} ns a frame</strong>.</p>\n",
                        to_string(query), xml_text(least->backend), least->facets, format_ns(least->frame_ns))
                  : fmt::format("<p class='gap'>Nothing serves {} within that.</p>\n", to_string(query));
  }
  HtmlTable table({"backend", "query", "facets", "pairs", "ns a frame", "error [m]", "serves"});
  for (const FacetRow& row : scene.facet_rows) {
    table.add({page.named(row.backend), std::string(to_string(row.query)), std::to_string(row.facets),
               format_count(row.pairs), format_ns(row.frame_ns), format_error(row.error),
               row.serves ? "yes" : "no"});
  }
  return html + "<details><summary>All rows</summary>" + table.str() + "</details>\n";
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
    const auto& frame = scene.set.backends[b].frame;
    table.add({page.named(backend.name), format_ns(median(frame[0])), format_ns(median(frame[1])),
               format_ns(median(frame[2])),
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
  return html + "</div>\n" + source_note(page, "scenes", "figures/scene_<name>.svg");
}

}  // namespace touchstone::comparison
