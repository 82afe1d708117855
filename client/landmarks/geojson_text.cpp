#include "client/landmarks/geojson_text.h"

#include <algorithm>
#include <cstddef>

#include "absl/strings/str_cat.h"

namespace dcloc {
namespace {

constexpr int kMaxNesting = 32;

// How deep brackets lie in one another, outside strings.
int NestingOf(absl::string_view text) {
  int depth = 0;
  int deepest = 0;
  bool is_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') is_string = !is_string;
    if (is_string) {
      if (c == '\\') ++i;  // what it escapes may be a quote
    } else if (c == '[' || c == '{') {
      deepest = std::max(deepest, ++depth);
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return deepest;
}

}  // namespace

absl::StatusOr<nlohmann::json> ParseGeoJson(absl::string_view text, absl::string_view name) {
  if (const int nesting = NestingOf(text); nesting > kMaxNesting) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, ": is nested ", nesting, " deep; it must be at most ", kMaxNesting));
  }
  nlohmann::json json = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (json.is_discarded()) return absl::DataLossError(absl::StrCat(name, ": is no JSON"));
  return json;
}

const nlohmann::json& MemberOf(const nlohmann::json& json, const char* name) {
  static const nlohmann::json kNull;
  if (!json.is_object()) return kNull;
  const auto member = json.find(name);
  return member == json.end() ? kNull : *member;
}

}  // namespace dcloc
