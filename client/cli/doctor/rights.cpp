#include "client/cli/doctor/rights.h"

#include <algorithm>

#include "client/sdk/admin_client.h"
#include "client/sdk/map_client.h"
#include "client/sdk/session.h"

namespace dcloc::cli {
namespace {

constexpr const char* kNothing = "dcloc-doctor-asks";  // no session and no build has this id

/// Whether a call was let through: what it then said of its request does not matter.
absl::Status LetThrough(const absl::Status& status) {
  const bool is_refused = absl::IsPermissionDenied(status) || absl::IsUnauthenticated(status) ||
                          absl::IsUnavailable(status) || absl::IsDeadlineExceeded(status);
  return is_refused ? status : absl::OkStatus();
}

}  // namespace

bool Rights::Grants(const std::string& permission) const {
  return std::ranges::any_of(
      calls, [&](const auto& call) { return call.first == permission && call.second.ok(); });
}

absl::Status Rights::Unauthenticated() const {
  for (const auto& [permission, status] : calls) {
    if (absl::IsUnauthenticated(status)) return status;
  }
  return absl::OkStatus();
}

std::string Rights::Role() const {
  if (Grants("manage_maps")) return "operator or admin";
  if (Grants("read_maps")) return "viewer";
  return Grants("localize") ? "vehicle" : "none";
}

Rights AskRights(const std::shared_ptr<grpc::Channel>& channel, std::chrono::milliseconds timeout) {
  client::AdminClient admin(channel, timeout);
  client::MapClient maps(channel, timeout);
  v1::FindCoverageRequest somewhere;
  somewhere.mutable_position()->set_latitude_deg(0.0);
  client::SessionOptions once;
  once.reconnect.reset();
  once.open_timeout = timeout;
  Rights rights;
  const auto add = [&](const char* permission, const absl::Status& status) {
    rights.calls.emplace_back(permission, LetThrough(status));
  };
  // Without a vehicle and a map no session is opened.
  add("localize", client::Session::Open(channel, v1::OpenSession(), once).status());
  add("read_coverage", maps.FindCoverage(somewhere).status());
  add("read_maps", maps.List().status());
  add("manage_maps", maps.CancelBuild(kNothing).status());
  add("read_sessions", admin.GetSession(kNothing).status());
  add("manage_sessions", admin.EndSession(kNothing, ""));
  add("read_server", admin.ServerState().status());
  // A vehicle opens sessions of its own name alone, so the call above was refused; the role that
  // may see places but no maps is a vehicle's.
  if (rights.Grants("read_coverage") && !rights.Grants("read_maps")) {
    rights.calls.front().second = absl::OkStatus();
  }
  return rights;
}

}  // namespace dcloc::cli
