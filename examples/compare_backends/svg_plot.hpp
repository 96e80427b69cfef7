#pragma once

#include <string>
#include <vector>

namespace touchstone::comparison {

/// CSS of the plots: light and dark.
std::string plot_style();

/// The opening tag of a plot. @param standalone with its own size, styles for light and dark, and paper;
/// otherwise for the page, which brings plot_style().
std::string svg_open(double width, double height, const std::string& label, bool standalone);

/// Marks: fourteen distinct shapes in Okabe and Ito's colours, as the CSS classes m0 to m13, by the backend's
/// place.
int place_of(const std::vector<std::string>& backends, const std::string& backend);
/// @param hollow for what has no speed.
std::string mark_at(int place, double x, double y, bool hollow, double radius = 6.0);
/// An open arrow beside a mark that is held at the end of an axis: its value lies further out. One of dx and
/// dy is -1 or 1: the way out in SVG's axes.
std::string held_mark(double x, double y, int dx, int dy);
/// A backend's mark alone, 16 by 16, for legends and tables.
std::string mark_svg(const std::vector<std::string>& backends, const std::string& backend);

std::string superscript(int exponent);       ///< of 10, as SVG text
std::string nanosecond_label(int exponent);  ///< "0.1 ns", "100 ns", "1 us": 10 to the exponent

/// Escapes &, <, > and quotes.
std::string xml_text(const std::string& text);

}  // namespace touchstone::comparison
