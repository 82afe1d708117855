#include "server/base/check.h"

#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/base/status.h"

namespace dcloc::server {
namespace {

constexpr std::size_t kMaxId = 64;
constexpr std::size_t kMaxMapName = 63;

bool IsIdCharacter(char c) {
  return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '_' || c == ':' ||
         c == '-';
}

bool IsMapNameCharacter(char c) {
  return absl::ascii_islower(static_cast<unsigned char>(c)) ||
         absl::ascii_isdigit(static_cast<unsigned char>(c)) || c == '-' || c == '_';
}

}  // namespace

absl::Status CheckBetween(absl::string_view field, double value, double min, double max) {
  if (value >= min && value <= max) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrFormat("%s is %g; it must lie in [%g, %g]", field, value, min, max));
}

absl::Status CheckIntegerBetween(absl::string_view field, long long value, long long min,
                                 long long max) {
  if (value >= min && value <= max) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrFormat("%s is %d; it must lie in [%d, %d]", field, value, min, max));
}

absl::Status CheckId(absl::string_view field, absl::string_view id) {
  if (!id.empty() && id.size() <= kMaxId && std::ranges::all_of(id, IsIdCharacter)) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrFormat(
      "%s is %s; it must have 1 to %d characters of A-Z, a-z, 0-9, '.', '_', ':' and '-'", field,
      Quoted(id), kMaxId));
}

absl::Status CheckMapName(absl::string_view field, absl::string_view name) {
  if (!name.empty() && name.size() <= kMaxMapName &&
      std::ranges::all_of(name, IsMapNameCharacter) && name[0] != '-' && name[0] != '_') {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrFormat("%s is %s; it must have 1 to %d characters of a-z, 0-9, '-' and '_', the "
                      "first one a letter or a digit",
                      field, Quoted(name), kMaxMapName));
}

absl::Status Missing(absl::string_view field) {
  return absl::InvalidArgumentError(absl::StrCat(field, " is missing"));
}

}  // namespace dcloc::server
