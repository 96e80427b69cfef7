#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace touchstone::program {

/// More lines than this cross too often to be followed: the page shows as many, the others where asked for.
inline constexpr std::size_t kFewLines = 6;
inline constexpr std::size_t kAllLines = static_cast<std::size_t>(-1);

/// CSS of the plots: light and dark.
std::string plot_style();

/// The opening tag of a plot. @param standalone with its own size, styles for light and dark, and paper;
/// otherwise for the page, which brings plot_style().
std::string svg_open(double width, double height, const std::string& label, bool standalone);

/// Marks: sixteen distinct shapes, each with a colour, as the CSS classes m0 to m15, by the backend's place.
int place_of(const std::vector<std::string>& backends, const std::string& backend);
/// @param hollow for what has no speed.
std::string mark_at(int place, double x, double y, bool hollow, double radius = 6.0);
/// An open arrow beside a mark that is held at the end of an axis: its value lies further out. One of dx and
/// dy is -1 or 1: the way out in SVG's axes.
std::string held_mark(double x, double y, int dx, int dy);
/// A backend's mark alone, 16 by 16, for legends and tables.
std::string mark_svg(const std::vector<std::string>& backends, const std::string& backend);

inline constexpr double kLegendStep = 16;
/// Marks and names below each other, for beside a plot. @param x, y of the first mark.
std::string plot_legend(const std::vector<std::string>& names, const std::vector<std::string>& backends,
                        double x, double y);
/// Heights for labels: as near as can be to the wanted ones (least squares), a gap apart at least, within low
/// and high as far as there is room. @pre wanted rises.
std::vector<double> spread(std::vector<double> wanted, double gap, double low, double high);

std::string superscript(int exponent);       ///< of 10, as SVG text
std::string nanosecond_label(int exponent);  ///< "0.1 ns", "100 ns", "1 us": 10 to the exponent

/// Escapes &, <, > and quotes.
std::string xml_text(const std::string& text);

}  // namespace touchstone::program
