#include "server/objects/object_options.h"

#include <algorithm>
#include <array>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "server/base/status.h"

namespace dcloc::server {
namespace {

bool ConsistsOf(absl::string_view text, absl::string_view others) {
  return std::ranges::all_of(text, [others](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || absl::StrContains(others, c);
  });
}

bool IsLowerCase(absl::string_view text) {
  return std::ranges::none_of(
      text, [](char c) { return absl::ascii_isupper(static_cast<unsigned char>(c)); });
}

bool IsBucket(absl::string_view name) {
  constexpr std::size_t kMin = 3;
  constexpr std::size_t kMax = 63;
  return name.size() >= kMin && name.size() <= kMax && ConsistsOf(name, "-.") &&
         IsLowerCase(name) && ConsistsOf(name.substr(0, 1), "") &&
         ConsistsOf(name.substr(name.size() - 1), "");
}

bool IsPrefix(absl::string_view prefix) {
  constexpr std::size_t kMax = 512;
  if (prefix.empty()) return true;
  const std::vector<absl::string_view> parts = absl::StrSplit(prefix, '/');
  return prefix.size() <= kMax && ConsistsOf(prefix, "._-/") &&
         std::ranges::none_of(parts, [](absl::string_view part) {
           return part.empty() || part == "." || part == "..";
         });
}

bool IsLoopback(absl::string_view host) {
  return host == "localhost" || host == "[::1]" || absl::StartsWith(host, "127.");
}

absl::Status Wrong(absl::string_view setting, absl::string_view value, absl::string_view what) {
  return absl::InvalidArgumentError(
      absl::StrCat(setting, " is ", Quoted(value), "; it must be ", what));
}

absl::Status ValidateEndpoint(const std::string& endpoint) {
  absl::string_view rest = endpoint;
  const bool secure = absl::ConsumePrefix(&rest, "https://");
  const bool plain = !secure && absl::ConsumePrefix(&rest, "http://");
  const std::size_t colon = rest.rfind(':');
  const bool has_port = colon != absl::string_view::npos && !absl::EndsWith(rest, "]");
  const absl::string_view host = has_port ? rest.substr(0, colon) : rest;
  int port = 1;
  const bool good_port =
      !has_port || (absl::SimpleAtoi(rest.substr(colon + 1), &port) && port >= 1 && port <= 65'535);
  if ((!secure && !plain) || host.empty() || !ConsistsOf(host, ".-:[]") || !good_port) {
    return Wrong("object_endpoint", endpoint, "of the form https://HOST:PORT, without a path");
  }
  if (secure || IsLoopback(host)) return absl::OkStatus();
  return Wrong("object_endpoint", endpoint,
               "https://..., as others on the network could read the maps; http:// is for this "
               "host alone");
}

}  // namespace

absl::StatusOr<ObjectLocation> ParseObjectLocation(absl::string_view location) {
  absl::string_view rest = location;
  const bool is_s3 = absl::ConsumePrefix(&rest, "s3://");
  const std::size_t slash = rest.find('/');
  ObjectLocation found{.bucket = std::string(rest.substr(0, slash)), .prefix = ""};
  if (slash != absl::string_view::npos) {
    found.prefix = std::string(absl::StripSuffix(rest.substr(slash + 1), "/"));
  }
  if (!is_s3 || !IsBucket(found.bucket) || !IsPrefix(found.prefix)) {
    return Wrong("map_files", location,
                 "of the form s3://BUCKET/PREFIX, with 3 to 63 lower-case letters, digits, \"-\" "
                 "and \".\" in BUCKET, and letters, digits, \".\", \"_\", \"-\" and \"/\" in "
                 "PREFIX");
  }
  if (!found.prefix.empty()) found.prefix += "/";
  return found;
}

absl::Status Validate(const ObjectOptions& options) {
  if (absl::Status status = ParseObjectLocation(options.location).status(); !status.ok()) {
    return status;
  }
  if (absl::Status status = ValidateEndpoint(options.endpoint); !status.ok()) return status;
  constexpr std::size_t kMaxRegion = 64;
  if (options.region.empty() || options.region.size() > kMaxRegion ||
      !ConsistsOf(options.region, "-")) {
    return Wrong("object_region", options.region, "1 to 64 letters, digits and \"-\"");
  }
  if (options.timeout < std::chrono::milliseconds(1)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("object_timeout_ms is %d; it must be at least 1", options.timeout.count()));
  }
  return absl::OkStatus();
}

}  // namespace dcloc::server
