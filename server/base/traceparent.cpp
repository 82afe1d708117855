#include "server/base/traceparent.h"

#include <algorithm>

namespace dcloc::server {
namespace {

// version "-" trace-id "-" parent-id "-" flags
constexpr std::size_t kVersionDigits = 2;
constexpr std::size_t kTraceDigits = 32;
constexpr std::size_t kParentDigits = 16;
constexpr std::size_t kFlagDigits = 2;
constexpr std::size_t kSize = kVersionDigits + kTraceDigits + kParentDigits + kFlagDigits + 3;

bool IsHex(absl::string_view text) {
  return std::ranges::all_of(
      text, [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

bool IsZero(absl::string_view text) {
  return std::ranges::all_of(text, [](char c) { return c == '0'; });
}

}  // namespace

std::string TraceIdOf(absl::string_view traceparent) {
  // Later versions may go on behind another dash.
  if (traceparent.size() < kSize) return "";
  const absl::string_view version = traceparent.substr(0, kVersionDigits);
  const absl::string_view trace = traceparent.substr(kVersionDigits + 1, kTraceDigits);
  const absl::string_view parent =
      traceparent.substr(kVersionDigits + kTraceDigits + 2, kParentDigits);
  const absl::string_view flags = traceparent.substr(kSize - kFlagDigits, kFlagDigits);
  const bool dashes = traceparent[kVersionDigits] == '-' &&
                      traceparent[kVersionDigits + 1 + kTraceDigits] == '-' &&
                      traceparent[kSize - kFlagDigits - 1] == '-';
  const bool ends = traceparent.size() == kSize || (version != "00" && traceparent[kSize] == '-');
  if (!dashes || !ends || version == "ff" || !IsHex(version) || !IsHex(trace) || !IsHex(parent) ||
      !IsHex(flags) || IsZero(trace) || IsZero(parent)) {
    return "";
  }
  return std::string(trace);
}

std::string TraceIdOf(const grpc::ServerContextBase& context) {
  const auto entry = context.client_metadata().find("traceparent");
  if (entry == context.client_metadata().end()) return "";
  return TraceIdOf(absl::string_view(entry->second.data(), entry->second.size()));
}

}  // namespace dcloc::server
