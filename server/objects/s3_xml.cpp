#include "server/objects/s3_xml.h"

#include <optional>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"

namespace dcloc::server {
namespace {

/// Takes the text of the next element of that name from the front of `xml`, with what is before
/// it. The elements that are asked for have no attributes and are in none of their own name.
std::optional<absl::string_view> Next(absl::string_view* xml, absl::string_view name) {
  const std::string opening = absl::StrCat("<", name, ">");
  const std::string closing = absl::StrCat("</", name, ">");
  const std::size_t begin = xml->find(opening);
  if (begin == absl::string_view::npos) return std::nullopt;
  const std::size_t end = xml->find(closing, begin);
  if (end == absl::string_view::npos) return std::nullopt;
  const std::size_t text = begin + opening.size();
  const absl::string_view found = xml->substr(text, end - text);
  xml->remove_prefix(end + closing.size());
  return found;
}

std::optional<absl::string_view> Find(absl::string_view xml, absl::string_view name) {
  return Next(&xml, name);
}

}  // namespace

absl::StatusOr<S3Page> ParseS3Page(absl::string_view xml) {
  const absl::Status malformed = absl::DataLossError("the answer is no list of objects");
  // Without its end it was cut off.
  if (xml.find("<ListBucketResult") == absl::string_view::npos ||
      xml.find("</ListBucketResult>") == absl::string_view::npos) {
    return malformed;
  }
  const std::optional<absl::string_view> truncated = Find(xml, "IsTruncated");
  if (!truncated) return malformed;
  S3Page page{.objects = {}, .is_last = *truncated == "false"};
  while (const std::optional<absl::string_view> contents = Next(&xml, "Contents")) {
    const std::optional<absl::string_view> key = Find(*contents, "Key");
    const std::optional<absl::string_view> size = Find(*contents, "Size");
    std::int64_t size_bytes = 0;
    if (!key || !size || !absl::SimpleAtoi(*size, &size_bytes) || size_bytes < 0) return malformed;
    page.objects.emplace_back(*key, size_bytes);
  }
  return page;
}

std::string S3ErrorCode(absl::string_view xml) {
  const std::optional<absl::string_view> error = Find(xml, "Error");
  const std::optional<absl::string_view> code = error ? Find(*error, "Code") : std::nullopt;
  constexpr std::size_t kMax = 64;
  std::string shown;
  for (const char c : code.value_or("").substr(0, kMax)) {
    if (absl::ascii_isalnum(static_cast<unsigned char>(c))) shown.push_back(c);
  }
  return shown;
}

}  // namespace dcloc::server
