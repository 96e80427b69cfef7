#include "touchstone/examples/fit/fit_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "touchstone/adapters/gltf/gltf_model.hpp"
#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/fit/page/page_text.hpp"
#include "touchstone/examples/program/files/json.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::fitting {
namespace {

using program::Json;
using program::xml_text;

constexpr std::size_t kWorstPlaces = 5;
constexpr std::size_t kMostShown = 150000;  // triangles of a mesh in the page: some megabytes

std::string millimetres(double metres) { return fmt::format("{:.4g} mm", 1e3 * metres); }

/// The hexahedra with the farthest points, farthest first.
std::vector<const FittedHexahedron*> worst_of(const Fit& fit) {
  std::vector<const FittedHexahedron*> all;
  for (const FittedHexahedron& each : fit.hexahedra) all.push_back(&each);
  std::stable_sort(all.begin(), all.end(),
                   [](const auto* a, const auto* b) { return a->excess > b->excess; });
  all.resize(std::min(all.size(), kWorstPlaces));
  return all;
}

/// One vertex a grid point of each face, `cells` squares along each side.
void add_faces(const MeshDistance& solid, const std::array<Vector3, 8>& vertices, int cells,
               ExcessSurface& out) {
  for (const auto& face : Hexahedron::kFaceVertices) {
    const auto first = static_cast<std::uint32_t>(out.points.size());
    for (int i = 0; i <= cells; ++i)
      for (int j = 0; j <= cells; ++j) {
        const double s = static_cast<double>(i) / cells, t = static_cast<double>(j) / cells;
        out.points.push_back((1 - s) * ((1 - t) * vertices[face[0]] + t * vertices[face[3]]) +
                             s * ((1 - t) * vertices[face[1]] + t * vertices[face[2]]));
        out.excess.push_back(solid.to_solid(out.points.back()));
      }
    const auto at = [&](int i, int j) {
      return first + static_cast<std::uint32_t>(i) * static_cast<std::uint32_t>(cells + 1) +
             static_cast<std::uint32_t>(j);
    };
    for (int i = 0; i < cells; ++i)
      for (int j = 0; j < cells; ++j) {
        out.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
        out.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
      }
  }
}

/// Points as integers of 16 bits in the box; triangles as indices, every `stride`-th of them.
Json packed(const Bounds& box, const std::vector<Vector3>& points,
            const std::vector<std::array<std::uint32_t, 3>>& triangles, std::size_t stride) {
  Json list = Json::array(), indices = Json::array();
  for (const Vector3& p : points)
    for (int i = 0; i < 3; ++i) {
      const double side = box.high[i] - box.low[i];
      list.push_back(side > 0.0 ? std::lround(65535.0 * (p[i] - box.low[i]) / side) : 32768);
    }
  for (std::size_t n = 0; n < triangles.size(); n += stride)
    for (const std::uint32_t i : triangles[n]) indices.push_back(i);
  return {{"points", std::move(list)}, {"triangles", std::move(indices)}};
}

std::size_t stride_for(const TriangleMesh& mesh) { return (mesh.triangles.size() - 1) / kMostShown + 1; }

Json page_data(const FitRun& run, const MeshDistance& solid, const ExcessSurface& surface) {
  Bounds box = solid.bounds();
  for (const Vector3& p : surface.points) box.add(p);
  Json data = {{"span", program::json(box.high - box.low)},
               {"middle", program::json(0.5 * (box.low + box.high))},
               {"mesh", packed(box, solid.mesh().vertices, solid.mesh().triangles, stride_for(solid.mesh()))},
               {"cover", packed(box, surface.points, surface.triangles, 1)}};
  Json values = Json::array();  // a triangle: 255 is the run's error
  for (const auto& t : surface.triangles) {
    const double mean = (surface.excess[t[0]] + surface.excess[t[1]] + surface.excess[t[2]]) / 3.0;
    values.push_back(std::lround(255.0 * std::min(mean / run.fit.excess, 1.0)));
  }
  data["cover"]["values"] = std::move(values);
  data["worst"] = Json::array();
  for (const FittedHexahedron* each : worst_of(run.fit))
    data["worst"].push_back({{"at", program::json(each->farthest)}, {"excess_m", each->excess}});
  return data;
}

std::string worst_table(const FitRun& run) {
  std::string html =
      "<table><thead><tr><th>place</th><th>error</th><th>x m</th><th>y m</th><th>z "
      "m</th></tr></thead><tbody>";
  int place = 0;
  for (const FittedHexahedron* each : worst_of(run.fit))
    html += fmt::format("<tr><td>{}, h{}</td><td>{}</td><td>{:.4g}</td><td>{:.4g}</td><td>{:.4g}</td></tr>",
                        ++place, each - run.fit.hexahedra.data(), millimetres(each->excess),
                        each->farthest.x(), each->farthest.y(), each->farthest.z());
  return html + "</tbody></table>";
}

/// A logarithmic axis over whole decades or, within one, over what is there.
struct Axis {
  double low, high, from, to;

  Axis(double least, double most, double from_, double to_)
      : low(std::log10(least) - 0.08), high(std::log10(most) + 0.08), from(from_), to(to_) {}
  double at(double value) const { return from + (to - from) * (std::log10(value) - low) / (high - low); }
};

/// 1, 2 and 5 times powers of ten that lie on the axis.
std::vector<double> ticks(const Axis& axis) {
  std::vector<double> out;
  for (int decade = static_cast<int>(std::floor(axis.low)); decade <= static_cast<int>(axis.high) + 1;
       ++decade)
    for (const double digit : {1.0, 2.0, 5.0}) {
      const double value = digit * std::pow(10.0, decade);
      if (std::log10(value) >= axis.low && std::log10(value) <= axis.high) out.push_back(value);
    }
  return out;
}

std::string curve_plot(const std::vector<CurvePoint>& curve) {
  constexpr double kWidth = 640, kHeight = 340, kLeft = 70, kRight = 620, kTop = 20, kBottom = 290;
  // The axes span all points of the curve.
  double least = curve[0].error, most = curve[0].error, few = 1e300, many = 1.0;
  for (const CurvePoint& p : curve) {
    least = std::min(least, p.error), most = std::max(most, p.error);
    few = std::min(few, static_cast<double>(p.hexahedra)),
    many = std::max(many, static_cast<double>(p.hexahedra));
  }
  const Axis x(1e3 * least, 1e3 * most, kLeft, kRight), y(few, many, kBottom, kTop);
  std::string svg = program::svg_open(kWidth, kHeight, "Hexahedra against error", false);
  svg += fmt::format("<rect class=\"area\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>", kLeft, kTop,
                     kRight - kLeft, kBottom - kTop);
  // Grid lines stand at round values.
  for (const double t : ticks(x))
    svg += fmt::format(
        "<path class=\"grid\" d=\"M{0:.1f} {1}V{2}\"/><text x=\"{0:.1f}\" y=\"{3}\" "
        "text-anchor=\"middle\">{4:g}</text>",
        x.at(t), kTop, kBottom, kBottom + 16, t);
  for (const double t : ticks(y))
    svg += fmt::format(
        "<path class=\"grid\" d=\"M{1} {0:.1f}H{2}\"/><text x=\"{3}\" y=\"{4:.1f}\" "
        "text-anchor=\"end\">{5:g}</text>",
        y.at(t), kLeft, kRight, kLeft - 6, y.at(t) + 4, t);
  // Each point has a mark and its count.
  std::string path;
  for (const CurvePoint& p : curve)
    path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x.at(1e3 * p.error),
                        y.at(static_cast<double>(p.hexahedra)));
  svg += "<path class=\"curve m0\" d=\"" + path + "\"/>";
  for (const CurvePoint& p : curve) {
    const double px = x.at(1e3 * p.error), py = y.at(static_cast<double>(p.hexahedra));
    svg +=
        program::mark_at(0, px, py, false) +
        fmt::format("<text class=\"label\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>", px + 8, py - 8, p.hexahedra);
  }
  return svg + fmt::format(
                   "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">error, an upper bound [mm]</text><text "
                   "x=\"{}\" y=\"14\">hexahedra</text></svg>",
                   0.5 * (kLeft + kRight), kHeight - 12, kLeft);
}

std::string curve_html(const std::vector<CurvePoint>& curve) {
  std::string html =
      "<div class=\"wide\">" + curve_plot(curve) +
      "</div><div class=\"wide\"><table><thead><tr><th>asked</th><th>error</th><th>hexahedra</th></tr>"
      "</thead><tbody>";
  for (const CurvePoint& p : curve)
    html += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td></tr>", millimetres(p.over),
                        millimetres(p.error), p.hexahedra);
  return html + "</tbody></table></div>";
}

/// Of the template; what stands in the texts is not looked at again.
std::string filled(std::string_view page, const std::vector<std::pair<std::string, std::string>>& texts) {
  std::string out;
  for (std::size_t at = 0;;) {
    const std::size_t open = page.find("{{", at);
    if (open == std::string_view::npos) return out + std::string(page.substr(at));
    const std::size_t close = page.find("}}", open);
    out += page.substr(at, open - at);
    const std::string_view name = page.substr(open + 2, close - open - 2);
    for (const auto& [key, text] : texts)
      if (key == name) out += text;
    at = close + 2;
  }
}

std::array<float, 3> blend(const std::array<float, 3>& a, const std::array<float, 3>& b, double share) {
  const auto s = static_cast<float>(std::clamp(share, 0.0, 1.0));
  return {a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1]), a[2] + s * (b[2] - a[2])};
}

}  // namespace

std::vector<CurvePoint> fit_curve(const FitRun& run, const FitRequest& request,
                                  program::ProgressLine& progress) {
  std::vector<CurvePoint> curve;
  const MeshDistance solid(weld(run.mesh));
  for (const double times : {8.0, 4.0, 2.0}) {
    FitOptions options;
    options.over = times * run.over;
    if (options.over > run.diagonal) continue;
    options.repairs = request.repairs;
    progress.step(fmt::format("fit within {}", millimetres(options.over)));
    options.progress = [&](std::string_view, double share) { progress.share(share); };
    const Fit fit = fit_hexahedra(run.mesh, options);
    curve.push_back({options.over, fit.excess, fit.hexahedra.size()});
  }
  curve.push_back({run.over, run.fit.excess, run.fit.hexahedra.size()});
  return curve;
}

ExcessSurface excess_surface(const MeshDistance& solid, const Fit& fit, std::size_t most_triangles) {
  const double squares_a_face =
      static_cast<double>(most_triangles) / (12.0 * static_cast<double>(fit.hexahedra.size()));
  const int cells = std::clamp(static_cast<int>(std::sqrt(squares_a_face)), 1, 16);
  ExcessSurface out;
  for (const FittedHexahedron& each : fit.hexahedra) add_faces(solid, each.vertices, cells, out);
  return out;
}

std::string fit_page(const FitRun& run, const MeshDistance& solid, const ExcessSurface& surface,
                     const std::vector<CurvePoint>& curve) {
  // A large mesh is shown in part, and the page says so.
  const std::size_t stride = stride_for(solid.mesh());
  const std::string shown =
      stride == 1 ? "are all triangles" : fmt::format("is every {}th triangle of the mesh", stride);
  // The script element would end at a '</' within its data.
  std::string data = page_data(run, solid, surface).dump();
  for (std::size_t at = 0; (at = data.find("</", at)) != std::string::npos;) data.insert(at + 1, "\\");
  const std::string summary = fmt::format(
      "{} triangles, {:.4g} m across, are {} hexahedra: no point of these is farther outside than {} ({:.3f} "
      "% of the diagonal); asked were {}.",
      program::format_count(run.triangles), run.diagonal, run.fit.hexahedra.size(),
      millimetres(run.fit.excess), 100.0 * run.fit.excess / run.diagonal, millimetres(run.over));
  // The page's template states whether the cover is proven.
  return filled(
      fit_page_text("page.html"),
      {{"title", "Cover of " + xml_text(run.certificate.mesh_file)},
       {"style", program::plot_style() + std::string(fit_page_text("page.css"))},
       {"summary", xml_text(summary)},
       {"proof_style", run.verdict.is_proven ? "soft" : "bad"},
       {"proof", run.verdict.is_proven ? "Proven: every triangle and the inside of closed shells are in "
                                         "the cover, and the error is a bound."
                                       : xml_text("Not proven: " + run.verdict.reason)},
       {"most", millimetres(run.fit.excess)},
       {"shown", shown},
       {"worst", worst_table(run)},
       {"curve", curve_html(curve)},
       {"data", data},
       {"script", std::string(fit_page_text("page.js"))}});
}

std::string fit_gltf(const FitRun& run, const MeshDistance& solid, const ExcessSurface& surface) {
  std::vector<GltfPart> parts;
  parts.push_back({"mesh", solid.mesh().vertices, solid.mesh().triangles, {{0.35F, 0.4F, 0.45F}}});
  GltfPart cover{"cover", surface.points, surface.triangles, {}, 0.5F};
  for (const double excess : surface.excess)
    cover.colours.push_back(blend({0.0F, 0.02F, 0.08F}, {0.99F, 0.8F, 0.05F}, excess / run.fit.excess));
  parts.push_back(std::move(cover));
  GltfPart places{"worst places", {}, {}, {{0.8F, 0.05F, 0.0F}}};
  const double half = 0.006 * run.diagonal;
  for (const FittedHexahedron* each : worst_of(run.fit)) {
    const auto first = static_cast<std::uint32_t>(places.vertices.size());
    for (int i = 0; i < 8; ++i)
      places.vertices.push_back(each->farthest + half * Vector3((i & 4) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1,
                                                                (i & 1) != 0 ? 1 : -1));
    for (const auto& face : Hexahedron::kFaceVertices) {
      places.triangles.push_back({first + face[0], first + face[1], first + face[2]});
      places.triangles.push_back({first + face[0], first + face[2], first + face[3]});
    }
  }
  parts.push_back(std::move(places));
  return gltf_model(parts);
}

}  // namespace touchstone::fitting
