#include "server/objects/response_status.h"

#include <algorithm>
#include <array>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/objects/s3_xml.h"

namespace dcloc::server {
namespace {

/// S3's codes of requests that came damaged or at a bad moment, with a status that says neither.
bool IsRetryable(const std::string& code) {
  constexpr std::array kCodes = {
      "BadDigest",      "IncompleteBody",     "InternalError", "OperationAborted",
      "RequestTimeout", "ServiceUnavailable", "SlowDown",      "XAmzContentSHA256Mismatch"};
  return std::ranges::find(kCodes, code) != kCodes.end();
}

bool IsRetryable(int status) {
  constexpr std::array kStatuses = {408, 429, 500, 502, 503, 504};
  return std::ranges::find(kStatuses, status) != kStatuses.end();
}

/// A good status, but not what was asked for.
absl::Status JudgeGood(const S3Request& request, const S3Answer& answer) {
  const bool whole = answer.status == 200;
  if (!request.range.empty() && whole && !absl::StartsWith(request.range, "0-")) {
    return absl::FailedPreconditionError("the service gives no ranges of objects");
  }
  if (answer.sink_bytes < request.sink.size()) {
    return absl::UnavailableError(absl::StrFormat("%d bytes came; %d were asked for",
                                                  answer.sink_bytes, request.sink.size()));
  }
  // A copy takes so long that the status may come before its result.
  const std::string code = request.sink.empty() ? S3ErrorCode(answer.text) : "";
  if (code.empty()) return absl::OkStatus();
  return absl::UnavailableError(absl::StrCat("the answer is ", code));
}

}  // namespace

absl::Status StatusOfResponse(const S3Request& request, const S3Answer& answer) {
  constexpr int kNotFound = 404;
  constexpr int kRangeNotSatisfiable = 416;
  const int status = answer.status;
  if (status >= 200 && status < 300) return JudgeGood(request, answer);
  const std::string code = S3ErrorCode(answer.text);
  const std::string text = absl::StrCat("the answer is ", status, code.empty() ? "" : " ", code);
  if (IsRetryable(status) || IsRetryable(code)) return absl::UnavailableError(text);
  if (status == kNotFound && code != "NoSuchBucket") return absl::NotFoundError(text);
  if (status == kRangeNotSatisfiable) return absl::OutOfRangeError(text);
  return absl::FailedPreconditionError(text);
}

}  // namespace dcloc::server
