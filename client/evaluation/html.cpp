#include "client/evaluation/html.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"

namespace dcloc {
namespace {

constexpr const char* kStyle =
    "body{font:15px/1.5 sans-serif;max-width:1500px;margin:2em auto;padding:0 1em;color:#222}"
    "table{border-collapse:collapse;margin:1em 0;display:block;overflow-x:auto;font-size:13px}"
    "td,th{padding:.25em .9em;border-bottom:1px solid #ddd;text-align:right}"
    "td:first-child,th:first-child{text-align:left}"
    "dl{display:grid;grid-template-columns:max-content auto;gap:.1em 1em}dd{margin:0}"
    "svg{width:100%;height:auto;max-height:85vh}";

std::string Row(const std::vector<std::string>& cells, const char* tag) {
  std::string row = "<tr>";
  for (const std::string& cell : cells) {
    absl::StrAppend(&row, "<", tag, ">", EscapeHtml(cell), "</", tag, ">");
  }
  return row + "</tr>\n";
}

}  // namespace

std::string EscapeHtml(absl::string_view text) {
  return absl::StrReplaceAll(text,
                             {{"&", "&amp;"}, {"<", "&lt;"}, {">", "&gt;"}, {"\"", "&quot;"}});
}

std::string HtmlTable(const std::vector<std::vector<std::string>>& rows) {
  std::string table = "<table>\n";
  for (std::size_t i = 0; i < rows.size(); ++i) table += Row(rows[i], i == 0 ? "th" : "td");
  return table + "</table>\n";
}

std::string HtmlPage(absl::string_view title, absl::string_view body) {
  const std::string escaped = EscapeHtml(title);
  return absl::StrCat("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>",
                      escaped, "</title><style>", kStyle, "</style></head><body>\n<h1>", escaped,
                      "</h1>\n", body, "</body></html>\n");
}

std::string InlineSvg(const std::string& svg) {
  const std::size_t begin = svg.find("<svg");
  return begin == std::string::npos ? svg : svg.substr(begin);
}

}  // namespace dcloc
