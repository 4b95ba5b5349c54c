// Every chart is a frame, a grid, the marks and a legend, written in this order; long series are
// thinned by the extremes of each pixel.
#include "tools/report/svg_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tools/report/axis.h"

namespace sanso::report {
namespace {

constexpr std::array<const char*, 8> kPalette{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                              "#e69f00", "#56b4e9", "#000000", "#999999"};
constexpr int kLeft = 62, kRight = 14, kTop = 30, kBottom = 44;  // margins around the plot area, px
// about two a pixel: more cannot be seen
constexpr std::size_t kMaxDrawnPoints = 1600;

std::string text_at(double x, double y, const std::string& text, const char* anchor, int size = 12,
                    const std::string& extra = {}) {
  return fmt::format("<text x='{:.1f}' y='{:.1f}' font-size='{}' text-anchor='{}' {}>{}</text>\n",
                     x, y, size, anchor, extra, escaped(text));
}

std::string open_svg(const std::string& title, ChartSize size) {
  return fmt::format(
             "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {0} {1}' width='{0}' "
             "height='{1}' "
             "font-family='DejaVu Sans, sans-serif' role='img' aria-label=\"{2}\">\n<rect "
             "width='{0}' height='{1}' "
             "fill='#ffffff'/>\n",
             size.width, size.height, escaped(title)) +
         text_at(kLeft, 18, title, "start", 14, "font-weight='bold'");
}

std::string vertical_label(const std::string& label, ChartSize size) {
  const double middle = 0.5 * (kTop + size.height - kBottom);
  return text_at(14, middle, label, "middle", 12,
                 fmt::format("transform='rotate(-90 14 {:.1f})'", middle));
}

Axis vertical_axis(const Range& range, bool logarithmic, ChartSize size) {
  Axis axis{range.low(), range.high(), static_cast<double>(size.height - kBottom),
            static_cast<double>(kTop), logarithmic};
  if (logarithmic) axis.low = std::max(axis.low, axis.high * 1e-6);
  return axis;
}

std::string horizontal_grid(const Axis& y, ChartSize size) {
  std::string out;
  for (double v : ticks(y.low, y.high, 6, y.logarithmic)) {
    const double py = y.pixel(v);
    out += fmt::format("<line x1='{}' x2='{}' y1='{:.1f}' y2='{:.1f}' stroke='#e3e3e3'/>\n", kLeft,
                       size.width - kRight, py, py);
    out += text_at(kLeft - 6, py + 4, tick_label(v), "end", 11);
  }
  return out;
}

std::string vertical_grid(const Axis& x, ChartSize size) {
  std::string out;
  const int bottom = size.height - kBottom;
  for (double v : ticks(x.low, x.high, 8, false)) {
    const double px = x.pixel(v);
    out += fmt::format("<line x1='{:.1f}' x2='{:.1f}' y1='{}' y2='{}' stroke='#e3e3e3'/>\n", px, px,
                       kTop, bottom);
    out += text_at(px, bottom + 16, tick_label(v), "middle", 11);
  }
  return out;
}

std::string frame(ChartSize size) {
  return fmt::format("<rect x='{}' y='{}' width='{}' height='{}' fill='none' stroke='#555555'/>\n",
                     kLeft, kTop, size.width - kLeft - kRight, size.height - kTop - kBottom);
}

std::string level_lines(const std::vector<Level>& levels, const Axis& y, ChartSize size) {
  std::string out;
  for (const Level& level : levels) {
    const double py = y.pixel(level.y);
    if (py < kTop || py > size.height - kBottom) continue;
    out += fmt::format(
        "<line x1='{}' x2='{}' y1='{:.1f}' y2='{:.1f}' stroke='#b00000' stroke-dasharray='3 3'/>\n",
        kLeft, size.width - kRight, py, py);
    out += text_at(size.width - kRight - 4, py - 4, level.label, "end", 11, "fill='#b00000'");
  }
  return out;
}

/// Indices to draw: all of them, or the lowest and highest of every bucket, so that no spike is
/// lost.
std::vector<std::size_t> drawn_points(const std::vector<double>& y) {
  std::vector<std::size_t> out;
  const std::size_t n = y.size();
  const std::size_t buckets = kMaxDrawnPoints / 2;
  for (std::size_t b = 0; n > kMaxDrawnPoints && b < buckets; ++b) {
    const std::size_t begin = b * n / buckets, end = (b + 1) * n / buckets;
    std::size_t low = begin, high = begin;
    for (std::size_t i = begin; i < end; ++i) {
      if (!std::isfinite(y[i])) {
        low = high = i;
        break;
      }  // the gap must stay visible
      if (y[i] < y[low]) low = i;
      if (y[i] > y[high]) high = i;
    }
    out.push_back(std::min(low, high));
    if (low != high) out.push_back(std::max(low, high));
  }
  for (std::size_t i = 0; n <= kMaxDrawnPoints && i < n; ++i) out.push_back(i);
  return out;
}

/// One polygon for every piece without NaN: along the upper edge, back along the lower.
std::string strip(const Ribbon& r, const Axis& x, const Axis& y) {
  std::string out;
  const auto inside = [&](double v) {
    return std::clamp(y.pixel(v), std::min(y.pixel_low, y.pixel_high),
                      std::max(y.pixel_low, y.pixel_high));
  };
  for (std::size_t first = 0; first < r.x.size();) {
    std::string upper, lower;
    std::size_t k = first;
    for (; k < r.x.size() && std::isfinite(r.low[k]) && std::isfinite(r.high[k]); ++k) {
      upper += fmt::format("{:.1f},{:.1f} ", x.pixel(r.x[k]), inside(r.high[k]));
      lower = fmt::format("{:.1f},{:.1f} ", x.pixel(r.x[k]), inside(r.low[k])) + lower;
    }
    if (k > first)
      out += "<polygon points='" + upper + lower + "' fill='" + r.colour + "' opacity='0.4'/>\n";
    first = k + 1;
  }
  return out;
}

std::string polyline(const Series& series, const std::string& colour, const Axis& x,
                     const Axis& y) {
  std::string path, dots;
  bool pen_down = false;
  for (std::size_t i : drawn_points(series.y)) {
    if (i >= series.x.size() || !std::isfinite(series.y[i]) || !std::isfinite(series.x[i])) {
      pen_down = false;
      continue;
    }
    const double px = x.pixel(series.x[i]), py = y.pixel(series.y[i]);
    path += fmt::format("{}{:.1f} {:.1f}", pen_down ? "L" : "M", px, py);
    if (series.markers)
      dots += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='2.6' fill='{}'/>\n", px, py, colour);
    pen_down = true;
  }
  return fmt::format("<path d='{}' fill='none' stroke='{}' stroke-width='1.6' {}/>\n", path, colour,
                     series.dashed ? "stroke-dasharray='6 4'" : "") +
         dots;
}

double legend_width(const Series& s) {
  return s.name.empty() ? 0.0 : 26.0 + 6.6 * static_cast<double>(s.name.size());
}

struct LegendRow {
  std::vector<std::size_t> series;
  double width = 0.0;
};

/// Names in as many rows as they need, none wider than `room`.
std::vector<LegendRow> legend_rows(const LineChart& chart, double room) {
  std::vector<LegendRow> rows(1);
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    const double width = legend_width(chart.series[i]);
    if (!rows.back().series.empty() && rows.back().width + width > room) rows.emplace_back();
    rows.back().series.push_back(i), rows.back().width += width;
  }
  return rows;
}

/// Right-aligned in the title's line; below it, inside the frame, where the title leaves too little
/// room.
std::string legend(const LineChart& chart, const std::vector<std::string>& colours,
                   ChartSize size) {
  constexpr double kTitleLetter = 7.6, kRowHeight = 18;  // px
  const std::vector<LegendRow> rows = legend_rows(chart, size.width - kRight - kLeft - 4);
  const bool beside =
      rows.size() == 1 &&
      kLeft + kTitleLetter * static_cast<double>(chart.title.size()) + rows.front().width <
          size.width - kRight;
  double middle = beside ? 20 : kTop + 12;
  std::string out;
  for (const LegendRow& row : rows) {
    double x = size.width - kRight - row.width;
    if (!beside) {
      out += fmt::format(
          "<rect x='{:.1f}' y='{}' width='{:.1f}' height='18' fill='#ffffff' opacity='0.85'/>\n",
          x - 4, middle - 9, row.width + 4);
    }
    for (const std::size_t i : row.series) {
      const Series& s = chart.series[i];
      if (s.name.empty()) continue;
      out += fmt::format(
          "<line x1='{0:.1f}' x2='{1:.1f}' y1='{2}' y2='{2}' stroke='{3}' stroke-width='2' {4}/>\n",
          x, x + 16, middle, colours[i], s.dashed ? "stroke-dasharray='4 3'" : "");
      out += text_at(x + 20, middle + 4, s.name, "start", 11);
      x += legend_width(s);
    }
    middle += kRowHeight;
  }
  return out;
}

using Rgb = std::array<double, 3>;
std::string mixed(const Rgb& a, const Rgb& b, double s) {
  const auto part = [&](int i) { return static_cast<int>(std::lround(a[i] + s * (b[i] - a[i]))); };
  return fmt::format("#{:02x}{:02x}{:02x}", part(0), part(1), part(2));
}

std::string cell_colour(double value, double low, double high, bool diverging) {
  constexpr Rgb white{255, 255, 255}, blue{0, 76, 130}, red{190, 60, 0};
  if (!diverging) return mixed(white, blue, std::clamp((value - low) / (high - low), 0.0, 1.0));
  const double most = std::max(std::abs(low), std::abs(high));
  return mixed(white, value < 0 ? blue : red, std::clamp(std::abs(value) / most, 0.0, 1.0));
}

/// A name over its column, in two lines where one would run into its neighbours.
std::string column_name(double x, double y, const std::string& name, double width) {
  constexpr double kLetter = 5.6, kLine = 13;  // pixels, of size 11
  const std::size_t space = name.rfind(' ', name.size() / 2 + 1);
  if (static_cast<double>(name.size()) * kLetter < width || space == std::string::npos)
    return text_at(x, y, name, "middle", 11);
  return text_at(x, y - kLine, name.substr(0, space), "middle", 11) +
         text_at(x, y, name.substr(space + 1), "middle", 11);
}

}  // namespace

std::string escaped(const std::string& text) {
  std::string out;
  for (char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string svg(const LineChart& chart, ChartSize size) {
  Range xs, ys;
  for (const Series& s : chart.series) {
    for (double v : s.x) xs.include(v);
    for (double v : s.y)
      if (!chart.log_y || v > 0) ys.include(v);
  }
  for (const Ribbon& r : chart.ribbons) {
    for (const auto* edge : {&r.low, &r.high}) {
      for (double v : *edge)
        if (!chart.log_y || v > 0) ys.include(v);
    }
  }
  if (chart.y_min) ys.include(*chart.y_min);
  if (chart.y_max) ys.include(*chart.y_max);
  const Range xr = xs.drawable(), yr = ys.drawable();
  const Axis x{xr.low(), xr.high(), static_cast<double>(kLeft),
               static_cast<double>(size.width - kRight)};
  const Axis y = vertical_axis(yr, chart.log_y, size);

  std::string out = open_svg(chart.title, size);
  for (const Band& band : chart.bands) {
    const double from = std::clamp(x.pixel(band.from), x.pixel_low, x.pixel_high);
    const double to = std::clamp(x.pixel(band.to), x.pixel_low, x.pixel_high);
    out += fmt::format(
        "<rect x='{:.1f}' y='{}' width='{:.1f}' height='{}' fill='{}' opacity='0.45'/>\n", from,
        kTop, to - from, size.height - kTop - kBottom, band.colour);
  }
  out += horizontal_grid(y, size) + vertical_grid(x, size) + frame(size);
  for (const Ribbon& r : chart.ribbons) out += strip(r, x, y);
  std::vector<std::string> colours;
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    const Series& s = chart.series[i];
    colours.push_back(s.colour.empty() ? kPalette[i % kPalette.size()] : s.colour);
    out += polyline(s, colours.back(), x, y);
  }
  out += level_lines(chart.levels, y, size) + legend(chart, colours, size);
  out += text_at(0.5 * (kLeft + size.width - kRight), size.height - 10, chart.x_label, "middle");
  return out + vertical_label(chart.y_label, size) + "</svg>\n";
}

std::string svg(const HeatMap& map, ChartSize size) {
  Range seen;
  for (const auto& row : map.values)
    for (double v : row) seen.include(v);
  if (map.low) seen.include(*map.low);
  if (map.high) seen.include(*map.high);
  const Range range = seen.drawable();
  constexpr int kNames = 130, kCellTop = 56;
  const double cell_w = (size.width - kNames - kRight) /
                        std::max<double>(1.0, static_cast<double>(map.columns.size()));
  const double cell_h =
      (size.height - kCellTop - 10) / std::max<double>(1.0, static_cast<double>(map.rows.size()));

  std::string out = open_svg(map.title + (map.unit.empty() ? "" : " [" + map.unit + "]"), size);
  for (std::size_t c = 0; c < map.columns.size(); ++c)
    out += column_name(kNames + (static_cast<double>(c) + 0.5) * cell_w, kCellTop - 8,
                       map.columns[c], cell_w);
  for (std::size_t r = 0; r < map.rows.size(); ++r) {
    const double top = kCellTop + static_cast<double>(r) * cell_h;
    out += text_at(kNames - 6, top + 0.5 * cell_h + 4, map.rows[r], "end", 11);
    for (std::size_t c = 0;
         c < map.columns.size() && r < map.values.size() && c < map.values[r].size(); ++c) {
      const double v = map.values[r][c];
      const bool known = std::isfinite(v);
      const std::string fill =
          known ? cell_colour(v, range.low(), range.high(), map.diverging) : "#f2f2f2";
      const double left = kNames + static_cast<double>(c) * cell_w;
      out += fmt::format(
          "<rect x='{:.1f}' y='{:.1f}' width='{:.1f}' height='{:.1f}' fill='{}' "
          "stroke='#ffffff'/>\n",
          left, top, cell_w, cell_h, fill);
      if (!known || cell_w < 34 || cell_h < 13) continue;
      const bool dark = !map.diverging && (v - range.low()) > 0.55 * (range.high() - range.low());
      out += text_at(left + 0.5 * cell_w, top + 0.5 * cell_h + 4, fmt::format("{:.3g}", v),
                     "middle", 10, dark ? "fill='#ffffff'" : "");
    }
  }
  return out + "</svg>\n";
}

}  // namespace sanso::report
