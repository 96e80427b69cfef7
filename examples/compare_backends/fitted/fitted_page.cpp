#include "touchstone/examples/compare_backends/fitted/fitted_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "touchstone/examples/compare_backends/figures/plot_scale.hpp"
#include "touchstone/examples/compare_backends/results/markdown.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"
#include "touchstone/examples/program/terminal/machine.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

constexpr const char* kIntroduction = R"(
Each mesh is covered within several errors, each cover proven. A cube is put at random poses near the surface, apart from the mesh,
and every backend is asked for the clearance to each cover, with `native`'s broadphase: one frame. In a row:

- geometry: the cover's certified error. `seen`: at least so much of it shows at these poses.
- backend: the worst difference of its clearance from `exact`'s on the same hexahedra.
- total: the worst difference of its clearance from the mesh's, an upper bound. The mesh's clearance is bracketed by all covers: at
  least the largest exact clearance, at most the least one with its certified error added.

A backend that refuses a pair that counts at a pose (`unsupported`, `failed`) has no total for it and no time. Times are the processor's,
of the run over all poses whose frames took least of several; read their ratios.
)";

constexpr std::size_t kTextColumns = 1;

bool has_times(const TotalErrors& errors) {
  return std::any_of(errors.rows.begin(), errors.rows.end(),
                     [](const TotalErrorRow& row) { return row.frame_ns > 0.0; });
}

bool has_figures(const TotalErrorRow& row) { return row.refused.empty() && row.unanswered == 0; }

const std::vector<std::string> kHead = {"backend",     "hexahedra", "geometry [m]",  "seen [m]",
                                        "backend [m]", "total [m]", "pairs a frame", "pair [ns]",
                                        "frame [us]",  "undecided"};

std::vector<std::string> cells_of(const TotalErrorRow& row, std::size_t poses) {
  std::vector<std::string> cells = {row.backend, std::to_string(row.hexahedra), format_error(row.geometry)};
  if (!has_figures(row)) {
    cells.insert(
        cells.end(),
        {"-", "-",
         row.refused.empty() ? fmt::format("unanswered: {} of {}", row.unanswered, poses) : "refused", "-",
         "-", "-", "-"});
    return cells;
  }
  cells.insert(
      cells.end(),
      {format_error(row.geometry_seen), format_error(row.backend_error), format_error(row.total),
       fmt::format("{:.1f}", row.pairs), row.frame_ns > 0.0 ? format_ns(row.pair_ns) : "-",
       row.frame_ns > 0.0 ? fmt::format("{:.3g}", 1e-3 * row.frame_ns) : "-", std::to_string(row.undecided)});
  return cells;
}

// By allowed error: a row wherever another one becomes the cheapest.
std::string steps_table(const TotalErrors& errors) {
  std::vector<double> totals;
  for (const TotalErrorRow& row : errors.rows)
    if (has_figures(row)) totals.push_back(row.total);
  std::sort(totals.begin(), totals.end());
  std::string text = markdown_head({"the cheapest", "from an allowed total error of [m]", "hexahedra",
                                    "frame [us]", "geometry [m]", "backend [m]"},
                                   kTextColumns);
  std::optional<std::size_t> last;
  for (const double total : totals) {  // those that differ by rounding alone are one
    const std::optional<std::size_t> best = cheapest_within(errors, total * (1.0 + 1e-6));
    if (!best || best == last) continue;
    last = best;
    const TotalErrorRow& row = errors.rows[*best];
    text += markdown_row({row.backend, format_error(row.total), std::to_string(row.hexahedra),
                          fmt::format("{:.3g}", 1e-3 * row.frame_ns), format_error(row.geometry),
                          format_error(row.backend_error)});
  }
  return text;
}

std::string mesh_line(const FittedMesh& mesh) {
  return fmt::format(
      "{} triangles, diagonal {:.4g} m; a cube of {:.3g} m at {} poses within {:.3g} m of it; the mesh's "
      "clearance is known to {} m",
      format_count(mesh.triangles), mesh.diagonal, mesh.side, mesh.poses, mesh.range,
      format_error(mesh.errors.bracket));
}

// ---- the plot

constexpr double kWidth = 640, kHeight = 330, kLeft = 60, kRight = 470, kTop = 30, kBottom = 280;

std::string axes(const LogScale& x, const LogScale& y, const std::string& title) {
  std::string svg = fmt::format(
      "<text class='title' x='{}' y='18'>{}</text><rect class='area' x='{}' y='{}' width='{}' "
      "height='{}'/>",
      kLeft, xml_text(title), kLeft, kTop, kRight - kLeft, kBottom - kTop);
  for (int e = static_cast<int>(x.low); e <= static_cast<int>(x.high); ++e)
    svg += fmt::format(
        "<path class='grid' d='M{0:.1f} {1}V{2}'/><text x='{0:.1f}' y='{3}' text-anchor='middle'>{4}</text>",
        x(std::pow(10.0, e)), kTop, kBottom, kBottom + 16, superscript(e));
  for (int e = static_cast<int>(y.low); e <= static_cast<int>(y.high); ++e)
    svg += fmt::format(
        "<path class='grid' d='M{} {:.1f}H{}'/><text x='{}' y='{:.1f}' text-anchor='end'>{}</text>", kLeft,
        y(std::pow(10.0, e)), kRight, kLeft - 6, y(std::pow(10.0, e)) + 4, nanosecond_label(e));
  return svg + fmt::format(
                   "<text x='{}' y='{}' text-anchor='middle'>total error [m]: geometry's and "
                   "backend's</text>",
                   (kLeft + kRight) / 2, kBottom + 36);
}

}  // namespace

std::string fitted_text(const FittedMesh& mesh) {
  TextTable table(kHead);
  for (const TotalErrorRow& row : mesh.errors.rows) table.add(cells_of(row, mesh.poses));
  return fmt::format("{}: {}\n\n{}\n", mesh.name, mesh_line(mesh), table.str());
}

std::string fitted_page(const std::vector<FittedMesh>& meshes, const std::string& command,
                        const std::vector<std::string>& failed) {
  std::string text = page_head("Cost against total error: geometry's and backend's", command) + kIntroduction;
  for (const std::string& reason : failed) text += fmt::format("\nNot measured: {}\n", reason);
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const FittedMesh& mesh = meshes[i];
    text += fmt::format("\n## {}\n\n{}.\n\n", mesh.name, mesh_line(mesh));
    if (!fitted_plot(mesh).empty())
      text += fmt::format("![Time a frame against total error]({})\n\n", fitted_plot_name(i));
    if (has_times(mesh.errors)) text += steps_table(mesh.errors) + "\n";
    text += markdown_head(kHead, kTextColumns);
    for (const TotalErrorRow& row : mesh.errors.rows) text += markdown_row(cells_of(row, mesh.poses));
    std::vector<std::string> refused;
    for (const TotalErrorRow& row : mesh.errors.rows)
      if (!row.refused.empty() && std::find(refused.begin(), refused.end(), row.backend) == refused.end()) {
        refused.push_back(row.backend);
        text += fmt::format("\n`{}` refuses: {}.\n", row.backend, row.refused);
      }
  }
  return text;
}

std::string fitted_plot(const FittedMesh& mesh) {
  // The rows that can be drawn, and the ranges that they span.
  std::vector<std::string> backends;
  std::vector<const TotalErrorRow*> rows;
  double least = 1e300, most = 0.0, fastest = 1e300, slowest = 0.0;
  for (const TotalErrorRow& row : mesh.errors.rows) {
    if (!has_figures(row) || !(row.frame_ns > 0.0) || !(row.total > 0.0) || !std::isfinite(row.total))
      continue;
    if (std::find(backends.begin(), backends.end(), row.backend) == backends.end())
      backends.push_back(row.backend);
    rows.push_back(&row);
    least = std::min(least, row.total), most = std::max(most, row.total);
    fastest = std::min(fastest, row.frame_ns), slowest = std::max(slowest, row.frame_ns);
  }
  if (rows.empty()) return "";
  // Axes around those ranges.
  const LogScale x = log_scale(decades_around(least, most), kLeft, kRight);
  const LogScale y = log_scale(decades_around(fastest, slowest), kBottom, kTop);
  std::string svg = svg_open(kWidth, kHeight, "time a frame against total error", true) +
                    axes(x, y, mesh.name + ", time a frame");
  // A curve a backend, with a mark at each cover.
  for (const std::string& backend : backends) {
    const int place = place_of(backends, backend);
    std::string line, marks;
    for (const TotalErrorRow* row : rows) {
      if (row->backend != backend) continue;
      line += fmt::format("{}{:.1f} {:.1f}", line.empty() ? "M" : "L", x(row->total), y(row->frame_ns));
      marks += fmt::format("<g><title>{}, {} hexahedra: {} m, {:.3g} us</title>{}</g>", xml_text(backend),
                           row->hexahedra, format_error(row->total), 1e-3 * row->frame_ns,
                           mark_at(place, x(row->total), y(row->frame_ns), false, 4.5));
    }
    svg += fmt::format("<path class='curve m{}' d='{}'/>{}", place, line, marks);
  }
  return svg + plot_legend(backends, backends, kRight + 20, kTop + 12) + "</svg>\n";
}

std::string fitted_plot_name(std::size_t mesh) { return fmt::format("fitted_{}.svg", mesh + 1); }

}  // namespace touchstone::comparison
