// A report page: one self-contained HTML file (figures inline as SVG, nothing fetched).
#pragma once

#include <string>
#include <vector>

#include "tools/report/svg_chart.h"

namespace sanso::report {

struct Table {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
};

/// Collects the parts in reading order. Every text is escaped; only figures and
/// markup() are taken as they are.
class HtmlPage {
 public:
  explicit HtmlPage(const std::string& title);
  void heading(const std::string& text);
  void paragraph(const std::string& text);
  /// A paragraph that stands out: the answer of the page. `good` chooses the colour of its edge.
  void answer(const std::string& text, bool good);
  void code(const std::string& text);
  void table(const Table& table);
  void figure(const std::string& svg_markup, const std::string& caption = {});
  /// Figures two abreast, in reading order; one abreast on a narrow screen.
  void gallery(const std::vector<std::string>& svg_markups);
  /// Markup as it is: made by this program, never by a person.
  void markup(const std::string& text) { body_ += text; }
  /// The whole file.
  std::string finish() const;

 private:
  std::string title_;
  std::string body_;
};

}  // namespace sanso::report
