// Charts as SVG text: lines, heat map. Values in, markup out; no state, no files. Colours are
// the Okabe-Ito palette, which colour-blind readers can tell apart. NaN breaks a line or leaves a
// cell empty.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace sanso::report {

struct ChartSize {
  int width = 720;   // px
  int height = 300;  // px
};

struct Series {
  std::string name;          // in the legend; empty: not listed
  std::vector<double> x, y;  // same length
  bool dashed = false;
  bool markers = false;     // a dot at every point
  std::string colour = {};  // "#rrggbb"; empty: next of the palette
};

/// A shaded interval of x: a regime, a stance phase, a fault.
struct Band {
  double from = 0.0, to = 0.0;
  std::string colour = "#cccccc";
};

/// A shaded strip between two curves: an interval, a noise band. NaN ends a piece.
struct Ribbon {
  std::vector<double> x, low, high;  // same length
  std::string colour = "#cccccc";
};

/// A horizontal line with a label: a limit, a budget.
struct Level {
  double y = 0.0;
  std::string label;
};

struct LineChart {
  std::string title, x_label, y_label;  // labels name the unit: "time [s]"
  std::vector<Series> series;
  std::vector<Band> bands = {};
  std::vector<Ribbon> ribbons = {};
  std::vector<Level> levels = {};
  std::optional<double> y_min = {}, y_max = {};  // else from the data
  bool log_y = false;
};

/// values[row][column]; the colour runs from white (low) to dark blue (high), or blue - white - red
/// when `diverging`.
struct HeatMap {
  std::string title, unit;
  std::vector<std::string> rows, columns;
  std::vector<std::vector<double>> values;
  bool diverging = false;
  std::optional<double> low = {}, high = {};  // else from the data
};

std::string svg(const LineChart& chart, ChartSize size = {});
std::string svg(const HeatMap& map, ChartSize size = {});

/// Text with &, <, >, " made safe for markup. Also used by the HTML page.
std::string escaped(const std::string& text);

}  // namespace sanso::report
