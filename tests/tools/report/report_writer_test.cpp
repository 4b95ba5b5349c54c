// Markup stays valid whatever the data: NaN, nothing, equal values, spikes, special characters.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "tools/report/axis.h"
#include "tools/report/html.h"
#include "tools/report/svg_chart.h"

namespace sanso::report {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(Ticks, AreRoundAndInside) {
  EXPECT_THAT(ticks(0.0, 1.0, 5, false),
              testing::Pointwise(testing::DoubleNear(1e-12), {0.0, 0.2, 0.4, 0.6, 0.8, 1.0}));
  for (double v : ticks(-0.37, 12.2, 6, false)) {
    EXPECT_GE(v, -0.37);
    EXPECT_LE(v, 12.2);
  }
  EXPECT_THAT(ticks(0.5, 2000.0, 6, true), testing::ElementsAre(1.0, 10.0, 100.0, 1000.0));
}

TEST(Range, OfNothingAndOfEqualValuesIsDrawable) {
  EXPECT_LT(Range().drawable().low(), Range().drawable().high());
  Range r;
  r.include(3.0);
  r.include(std::numeric_limits<double>::quiet_NaN());
  EXPECT_LT(r.drawable().low(), 3.0);
  EXPECT_GT(r.drawable().high(), 3.0);
}

TEST(LineChart, NanBreaksTheLineAndNeverReachesTheMarkup) {
  LineChart chart{.title = "a < b",
                  .x_label = "t [s]",
                  .y_label = "y",
                  .series = {{"s", {0, 1, 2, 3, 4}, {0, 1, std::nan(""), 3, 4}}}};
  const std::string out = svg(chart);
  EXPECT_THAT(out, HasSubstr("a &lt; b"));
  EXPECT_THAT(out, Not(HasSubstr("nan")));
  std::size_t moves = 0;
  for (std::size_t at = out.find("d='"); at < out.find("' fill='none' stroke='#0072b2'"); ++at)
    moves += out[at] == 'M';
  EXPECT_EQ(moves, 2u);
}

TEST(LineChart, EveryNameOfALongLegendIsInsideTheChart) {
  LineChart chart{.title = "joints", .x_label = "", .y_label = "", .series = {}};
  for (int i = 0; i < 20; ++i)
    chart.series.push_back({"left_shoulder_pitch " + std::to_string(i), {0, 1}, {0, 1}});
  const ChartSize size{720, 300};
  const std::string out = svg(chart, size);
  int names = 0;
  for (std::size_t at = out.find("<line x1='"); at != std::string::npos;
       at = out.find("<line x1='", at + 1)) {
    const double x = std::stod(out.substr(at + 10));
    EXPECT_GE(x, 0.0);
    EXPECT_LT(x, size.width);
  }
  for (std::size_t at = out.find("left_shoulder_pitch"); at != std::string::npos;
       at = out.find("left_shoulder_pitch", at + 1)) {
    const std::size_t text = out.rfind("<text x='", at);
    EXPECT_GE(std::stod(out.substr(text + 9)), 0.0);
    ++names;
  }
  EXPECT_EQ(names, 20);
}

TEST(LineChart, ASpikeAmongMillionPointsStaysVisible) {
  Series s{"", {}, {}};
  for (int i = 0; i < 200000; ++i) {
    s.x.push_back(i);
    s.y.push_back(i == 123457 ? 1.0 : 0.0);
  }
  LineChart chart{.title = "spike", .x_label = "", .y_label = "", .series = {s}};
  const std::string out = svg(chart, {720, 300});
  EXPECT_THAT(out, HasSubstr(" 30.0L"));  // the top of the plot area is reached
  EXPECT_LT(out.size(), 60000u);
}

TEST(HeatMap, EmptyCellsAreGrey) {
  HeatMap map{.title = "m",
              .unit = "rad",
              .rows = {"r"},
              .columns = {"a", "b"},
              .values = {{1.0, std::nan("")}}};
  EXPECT_THAT(svg(map), HasSubstr("#f2f2f2"));
}

TEST(HtmlPage, EscapesEverythingButFigures) {
  HtmlPage page("x & y");
  page.table({{"a"}, {{"<script>"}}});
  page.figure("<svg></svg>", "c < d");
  const std::string out = page.finish();
  EXPECT_THAT(out, HasSubstr("x &amp; y"));
  EXPECT_THAT(out, Not(HasSubstr("<script>")));
  EXPECT_THAT(out, HasSubstr("<svg></svg>"));
  EXPECT_THAT(out, HasSubstr("c &lt; d"));
}

TEST(LineChart, RibbonIsOnePolygonForEveryPieceWithoutNaN) {
  LineChart chart{"a", "x", "y", {}};
  chart.ribbons = {{{0, 1, 2, 3, 4}, {0, 0, NAN, 0, 0}, {1, 1, 1, 1, 1}}};
  const std::string text = svg(chart);
  EXPECT_THAT(text, HasSubstr("<polygon"));
  EXPECT_EQ(text.find("<polygon", text.find("<polygon") + 1) != std::string::npos, true);
  EXPECT_THAT(text, Not(HasSubstr("nan")));
}

}  // namespace
}  // namespace sanso::report
