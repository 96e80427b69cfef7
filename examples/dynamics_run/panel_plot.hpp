#pragma once

#include <string>
#include <vector>

namespace touchstone::dynamics {

/// A line over time.
struct PlotLine {
  std::string name;       ///< in its panel's legend; lines of one name share a dash
  std::size_t colour;     ///< an index into the plot's colours
  std::vector<double> y;  ///< one a time
};

/// Lines in one unit over the plot's times.
struct PlotPanel {
  std::string title;
  std::vector<PlotLine> lines;
};

struct PanelPlot {
  std::string title;
  std::vector<std::string> colours;        ///< what each stands for
  std::vector<std::vector<double>> times;  ///< by colour [s]
  std::vector<PlotPanel> panels;
};

/// Panels one below the other over one axis of time, as SVG with its own styles, for light and dark. A line
/// of more points than the panel has places keeps the least and the largest of each place.
std::string panel_plot(const PanelPlot& plot);

}  // namespace touchstone::dynamics
