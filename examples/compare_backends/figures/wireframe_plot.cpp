#include "touchstone/examples/compare_backends/figures/wireframe_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "touchstone/examples/program/plots/svg_plot.hpp"

namespace touchstone::comparison {
namespace {

constexpr double kWidth = 380, kHeight = 250, kTop = 26, kInset = 14, kArrow = 52;

// Orthographic, the normal to the right; pixels.
struct View {
  Vector3 right, up;
  double scale = 1;
  double x0 = 0, y0 = 0;

  double x(const Vector3& p) const { return x0 + scale * dot(p, right); }
  double y(const Vector3& p) const { return y0 - scale * dot(p, up); }
};

View look_across(const GalleryCase& shown) {
  // The normal lies across the picture, so that gap or depth is seen in full.
  Vector3 n = shown.truth.n_AB_W;
  if (!is_finite(n) || !(norm(n) > 0)) n = Vector3::UnitX();
  n /= norm(n);
  // The axis that is least along the normal gives the other direction.
  Vector3 hint = Vector3::Zero();
  int least = 0;
  for (int axis = 1; axis < 3; ++axis) {
    if (std::abs(n[axis]) < std::abs(n[least])) least = axis;
  }
  hint[least] = 1.0;
  Vector3 side = cross(n, hint);
  side /= norm(side);
  View view;
  view.right = n;
  view.up = side * 0.8 + cross(n, side) * 0.6;  // turned, so that edges along the axes do not hide each other
  // Both solids fill the picture.
  double left = 1e300, right = -1e300, low = 1e300, high = -1e300;
  for (int v = 0; v < 16; ++v) {
    const Vector3 p = v < 8 ? shown.posed.a.vertex(v) : shown.posed.b.vertex(v - 8);
    left = std::min(left, dot(p, view.right)), right = std::max(right, dot(p, view.right));
    low = std::min(low, dot(p, view.up)), high = std::max(high, dot(p, view.up));
  }
  view.scale = std::min((kWidth - 2 * kInset) / (right - left), (kHeight - kTop - 2 * kInset) / (high - low));
  view.x0 = kWidth / 2 - view.scale * (left + right) / 2;
  view.y0 = kTop + (kHeight - kTop) / 2 + view.scale * (low + high) / 2;
  return view;
}

std::string edges(const WorldVertices& solid, const View& view, const char* style) {
  std::string path;
  for (const auto& [from, to] : Hexahedron::kEdgeVertices) {
    path += fmt::format("M{:.1f} {:.1f}L{:.1f} {:.1f}", view.x(solid.vertex(from)),
                        view.y(solid.vertex(from)), view.x(solid.vertex(to)), view.y(solid.vertex(to)));
  }
  return fmt::format("<path class='{}' d='{}'/>", style, path);
}

// The middle of A's vertices that lie furthest along the normal.
Vector3 front_of(const WorldVertices& solid, const Vector3& n) {
  double furthest = -1e300, nearest = 1e300;
  for (int v = 0; v < 8; ++v) {
    furthest = std::max(furthest, dot(solid.vertex(v), n));
    nearest = std::min(nearest, dot(solid.vertex(v), n));
  }
  Vector3 sum = Vector3::Zero();
  int count = 0;
  for (int v = 0; v < 8; ++v) {
    if (dot(solid.vertex(v), n) < furthest - 1e-6 * (furthest - nearest)) continue;  // a pixel is coarser
    sum += solid.vertex(v);
    ++count;
  }
  return sum / std::max(count, 1);
}

std::string arrow(double x, double y, double dx, double dy, const std::string& style) {
  const double length = std::sqrt(dx * dx + dy * dy);
  std::string path = fmt::format("M{:.1f} {:.1f}l{:.1f} {:.1f}", x, y, dx, dy);
  if (length > 8) {
    const double ux = dx / length, uy = dy / length;
    path += fmt::format("l{:.1f} {:.1f}m{:.1f} {:.1f}l{:.1f} {:.1f}", -7 * ux + 3.5 * uy, -7 * uy - 3.5 * ux,
                        7 * ux - 3.5 * uy, 7 * uy + 3.5 * ux, -7 * ux - 3.5 * uy, -7 * uy + 3.5 * ux);
  }
  return fmt::format("<path class='{}' d='{}'/>", style, path);
}

}  // namespace

std::string wireframe_plot(const GalleryCase& shown, const std::vector<std::string>& backends,
                           bool standalone) {
  const View view = look_across(shown);
  std::string svg = svg_open(kWidth, kHeight, shown.id + ": the two solids", standalone);
  svg += fmt::format("<text class='title' x='8' y='16'>{}</text>", xml_text(shown.id));
  svg += edges(shown.posed.a, view, "solid-a") + edges(shown.posed.b, view, "solid-b");
  const Vector3 at = front_of(shown.posed.a, view.right);
  const double x = view.x(at), y = view.y(at);
  svg += "<g><title>exact normal</title>" + arrow(x, y, kArrow, 0, "exact") + "</g>";
  for (const GalleryCase::Answer& answer : shown.answers) {
    if (!std::isfinite(answer.separation) || !is_finite(answer.n_AB_W)) continue;
    const double dx = kArrow * dot(answer.n_AB_W, view.right), dy = -kArrow * dot(answer.n_AB_W, view.up);
    const int place = place_of(backends, answer.backend);
    svg += fmt::format("<g><title>{}</title>", xml_text(answer.backend)) +
           arrow(x, y, dx, dy, fmt::format("arrow curve m{}", place)) +
           mark_at(place, x + 1.15 * dx, y + 1.15 * dy, false, 4.2) + "</g>";
  }
  return svg + "</svg>\n";
}

}  // namespace touchstone::comparison
