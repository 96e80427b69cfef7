#include <fmt/format.h>

#include <cmath>

#include "touchstone/examples/compare_backends/figures/wireframe_plot.hpp"
#include "touchstone/examples/compare_backends/page/sections.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

std::string normal_text(const Vector3& n) {
  return is_finite(n) ? fmt::format("{:.3f} {:.3f} {:.3f}", n.x(), n.y(), n.z()) : "-";
}

std::string one_case(const Page& page, const GalleryCase& shown) {
  std::string html = "<figure>" + wireframe_plot(shown, page.names, false);
  html += fmt::format("<figcaption>{}, {}: {}, {} m ({} S)<br><code>{}</code>", page.named(shown.backend),
                      to_string(shown.query), xml_text(shown.reason), format_error(shown.cost),
                      format_error(shown.cost / shown.posed.scale), xml_text(shown.replay));
  HtmlTable table({"answer", "class", "separation [m]", "normal"});
  table.add(
      {"exact", std::string(to_string(shown.truth.pair_class)), fmt::format("{:.6g}", shown.truth.separation),
       normal_text(shown.truth.n_AB_W) + (shown.truth.normal_unique ? "" : " (one of several)")},
      "exact-row");
  for (const GalleryCase::Answer& answer : shown.answers) {
    table.add({page.named(answer.backend), std::string(to_string(answer.status)),
               std::isfinite(answer.separation) ? fmt::format("{:.6g}", answer.separation) : "-",
               std::isfinite(answer.separation) ? normal_text(answer.n_AB_W) : "-"});
  }
  return html + table.str() + "</figcaption></figure>\n";
}

}  // namespace

std::string gallery_section(const Page& page) {
  if (!page.report.has_truth || (page.report.sets.empty() && page.report.scenes.empty())) return "";
  std::string html = "<h2>Worst cases</h2>\n";
  if (page.report.gallery.empty()) return html + "<p>No backend erred.</p>\n";
  html += fmt::format(
      "<p>Of each backend and set, scenes too, the answer with the largest error over S: of all queries, a "
      "figure that it carries (distance, depth, normal, points), or a contact missed or reported where none "
      "is, by the exact separation. The {} worst of these, at most {} of one backend, so that one backend's "
      "many do not hide the others' few. Answers that claim nothing (undecided, failed, unsupported) are not "
      "among them. Solid lines: A, dashed: B, seen across the exact normal, which lies level. Thick arrow: "
      "the exact normal; thin arrows with marks: the backends' (shorter where they leave the picture's "
      "plane). The command shows every digit.</p>\n<div class='gallery'>\n",
      page.report.gallery.size(), kGalleryOfOne);
  for (const GalleryCase& shown : page.report.gallery) html += one_case(page, shown);
  return html + "</div>\n" + source_note("gallery", "figures/worst_<number>.svg");
}

}  // namespace touchstone::comparison
