#include "server/net/call_gate.h"

#include "absl/strings/match.h"
#include "absl/strings/str_format.h"
#include "server/base/status.h"
#include "server/base/within_memory.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

constexpr std::size_t kManyConnections = 1024;
/// A connection that began no call for so long has its whole burst again.
constexpr std::chrono::seconds kForgotten(2);

bool IsForEveryone(absl::string_view path) {
  return absl::StartsWith(path, "/grpc.health.v1.") || absl::StartsWith(path, "/grpc.reflection.");
}

}  // namespace

absl::Status CallGate::Admit(const void* connection, absl::string_view path, bool has_proof,
                             RateLimit::Clock::time_point now) {
  const bool proof_needed = proof_needed_;
  if (max_rate_hz_ > 0 && !TakeRate(connection, now)) {
    ++refused_.too_fast;
    return absl::ResourceExhaustedError(absl::StrFormat(
        "calls begin faster on this connection than max_call_rate_hz_per_connection, which is %d",
        max_rate_hz_));
  }
  if (reserve_.IsGiven() && !IsForEveryone(path)) {
    ++refused_.out_of_memory;
    return OutOfMemory();
  }
  if (!proof_needed || has_proof || IsForEveryone(path)) return absl::OkStatus();
  ++refused_.without_proof;
  spdlog::warn("denied path={} reason=\"no identity\"", Quoted(path));
  return absl::UnauthenticatedError(
      "no identity: send \"authorization: Bearer TOKEN\" or a client certificate");
}

bool CallGate::TakeRate(const void* connection, RateLimit::Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  if (rates_.size() >= kManyConnections) {
    std::erase_if(rates_,
                  [now](const auto& entry) { return now - entry.second.last > kForgotten; });
  }
  Rate& rate = rates_[connection];
  rate.last = now;
  return rate.limit.Take(max_rate_hz_, now);
}

}  // namespace dcloc::server
