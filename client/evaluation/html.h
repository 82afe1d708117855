#pragma once

#include <string>
#include <vector>

#include "absl/strings/string_view.h"

namespace dcloc {

/// `text` as HTML text or attribute value.
std::string EscapeHtml(absl::string_view text);

/// A table, its first row being the header; cells are text.
std::string HtmlTable(const std::vector<std::vector<std::string>>& rows);

/// A whole page, with our style, around `body`.
std::string HtmlPage(absl::string_view title, absl::string_view body);

/// A drawing of gnuplot's as it may stand within a page: without the XML declaration, which may
/// only stand at a file's own beginning.
std::string InlineSvg(const std::string& svg);

}  // namespace dcloc
