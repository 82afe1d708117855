#include "server/convert/page.h"

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "server/base/check.h"
#include "server/base/status.h"

namespace dcloc::server::convert {
namespace {

constexpr int kDefaultPageSize = 100;
constexpr int kMaxPageSize = 1000;

absl::Status BadToken(const std::string& page_token) {
  return absl::InvalidArgumentError(absl::StrCat("page_token is ", Quoted(page_token),
                                                 "; it must be empty or from the page before"));
}

}  // namespace

absl::StatusOr<int> PageSizeFromProto(std::int32_t page_size) {
  absl::Status status = CheckIntegerBetween("page_size", page_size, 0, kMaxPageSize);
  if (!status.ok()) return status;
  return page_size == 0 ? kDefaultPageSize : page_size;
}

absl::StatusOr<std::int64_t> NumberFromPageToken(const std::string& page_token,
                                                 std::int64_t first) {
  if (page_token.empty()) return first;
  std::int64_t number = 0;
  if (!absl::SimpleAtoi(page_token, &number) || number < 1) return BadToken(page_token);
  return number;
}

absl::Status CheckPageToken(const std::string& page_token) {
  if (page_token.empty() || CheckId("page_token", page_token).ok()) return absl::OkStatus();
  return BadToken(page_token);
}

}  // namespace dcloc::server::convert
