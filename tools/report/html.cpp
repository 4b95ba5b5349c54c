// Collects the body as text and closes it in finish(); all text is escaped, only figures pass as
// markup.
#include "tools/report/html.h"

#include <cctype>

namespace sanso::report {
namespace {

constexpr const char* kStyle =
    "body{font-family:'DejaVu Sans',sans-serif;max-width:1100px;margin:2em auto;padding:0 "
    "1em;color:#222;background:#fff}"
    "h1{font-size:1.5em}h2{font-size:1.15em;margin-top:1.8em;border-bottom:1px solid #ddd}"
    "table{border-collapse:collapse;font-size:.88em;margin:.8em 0}td,th{border:1px solid "
    "#ccc;padding:.25em "
    ".7em;text-align:right}"
    "td:first-child,th:first-child,.text{text-align:left}th{background:#f3f3f3}tr:nth-child(even) "
    "td{background:#fafafa}"
    ".answer{border-left:6px solid;padding:.6em "
    "1em;background:#f7f7f7;font-size:1.05em}.good{border-color:#009e73}.bad{border-color:#d55e00}"
    "figure{margin:1em 0}figure "
    "svg{max-width:100%;height:auto}figcaption{font-size:.85em;color:#555}"
    ".gallery{display:grid;grid-template-columns:1fr 1fr;gap:.2em 1.2em}.gallery "
    "figure{margin:.3em 0}"
    "@media(max-width:800px){.gallery{grid-template-columns:1fr}}"
    "pre{background:#f5f5f5;padding:.7em;overflow-x:auto;font-size:.85em}";

std::string table_row(const std::vector<std::string>& cells, const char* tag) {
  std::string out = "<tr>";
  for (const std::string& cell : cells) {
    const bool number = !cell.empty() && (std::isdigit(static_cast<unsigned char>(cell.front())) ||
                                          cell.front() == '-');
    out += std::string("<") + tag + (number ? "" : " class='text'") + ">" + escaped(cell) + "</" +
           tag + ">";
  }
  return out + "</tr>\n";
}

}  // namespace

HtmlPage::HtmlPage(const std::string& title) : title_(title) {
  body_ = "<h1>" + escaped(title) + "</h1>\n";
}
void HtmlPage::heading(const std::string& text) { body_ += "<h2>" + escaped(text) + "</h2>\n"; }
void HtmlPage::paragraph(const std::string& text) { body_ += "<p>" + escaped(text) + "</p>\n"; }
void HtmlPage::code(const std::string& text) { body_ += "<pre>" + escaped(text) + "</pre>\n"; }

void HtmlPage::answer(const std::string& text, bool good) {
  body_ +=
      std::string("<p class='answer ") + (good ? "good" : "bad") + "'>" + escaped(text) + "</p>\n";
}

void HtmlPage::table(const Table& table) {
  body_ += "<table>\n" + table_row(table.header, "th");
  for (const auto& row : table.rows) body_ += table_row(row, "td");
  body_ += "</table>\n";
}

void HtmlPage::figure(const std::string& svg_markup, const std::string& caption) {
  body_ += "<figure>" + svg_markup;
  if (!caption.empty()) body_ += "<figcaption>" + escaped(caption) + "</figcaption>";
  body_ += "</figure>\n";
}

void HtmlPage::gallery(const std::vector<std::string>& svg_markups) {
  body_ += "<div class='gallery'>\n";
  for (const std::string& markup : svg_markups) figure(markup);
  body_ += "</div>\n";
}

std::string HtmlPage::finish() const {
  return "<!DOCTYPE html>\n<html lang='en'><head><meta charset='utf-8'><meta name='viewport' "
         "content='width=device-width'>"
         "<title>" +
         escaped(title_) + "</title><style>" + kStyle + "</style></head>\n<body>\n" + body_ +
         "</body></html>\n";
}

}  // namespace sanso::report
