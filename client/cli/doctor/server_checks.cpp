#include "client/cli/doctor/server_checks.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "client/cli/doctor/clock_probe.h"
#include "client/cli/doctor/rights.h"
#include "client/cli/doctor/tls_probe.h"
#include "client/sdk/admin_client.h"
#include "client/sdk/map_client.h"

namespace dcloc::cli {
namespace {

using enum CheckResult;

constexpr std::int64_t kSecondsPerDay = 86'400;
constexpr std::int64_t kExpiresSoon_days = 14;
constexpr double kClockTolerance_s = 0.1;
constexpr double kFarthest_m = 10'000.0;   // that FindCoverage takes
constexpr double kNear_m = 25.0;           // of mapped street: the width of a road with its sides
constexpr double kBetweenPlaces_m = 25.0;  // of a drive that are asked for
constexpr std::size_t kMaxPlaces = 60;

std::string DateText(std::int64_t seconds) {
  return absl::FormatTime("%Y-%m-%d", absl::FromUnixSeconds(seconds), absl::UTCTimeZone());
}

Finding CertificateDates(const TlsProbe& probe) {
  const std::int64_t now_s = absl::ToUnixSeconds(absl::Now());
  const std::int64_t left_days = (probe.not_after_s - now_s) / kSecondsPerDay;
  Finding finding{
      "certificate dates", kOk,
      absl::StrFormat("from %s to %s", DateText(probe.not_before_s), DateText(probe.not_after_s)),
      ""};
  if (now_s < probe.not_before_s) {
    finding.result = kFailed;
    finding.advice = "it does not hold yet: compare this machine's clock";
  } else if (now_s >= probe.not_after_s) {
    finding.result = kFailed;
    finding.advice =
        "it has expired: give the server a new one; it reads its files again by itself";
  } else if (left_days < kExpiresSoon_days) {
    finding.result = kWarning;
    finding.advice = absl::StrCat("it expires in ", left_days, " days: renew it");
  }
  return finding;
}

Finding CertificateTrust(const TlsProbe& probe, const std::string& authority) {
  Finding finding{"certificate", kOk,
                  absl::StrCat("is trusted by ", authority, " and for ", probe.expected_name), ""};
  if (probe.fault.empty()) return finding;
  finding.result = kFailed;
  finding.what = absl::StrCat("is not trusted: ", probe.fault);
  const bool is_name =
      absl::StrContains(probe.fault, "ostname") || absl::StrContains(probe.fault, "IP address");
  finding.advice =
      is_name
          ? absl::StrCat("it is for ", probe.names.empty() ? "no name" : probe.names, ", not for ",
                         probe.expected_name, ": use such a name, or give it as --tls-server-name")
          : absl::StrCat("give the authority that signed it as --tls-ca; this is ", authority);
  return finding;
}

/// One run over one server, check by check.
class ServerExamination {
 public:
  ServerExamination(const ServerCheckOptions& options, const Drive* drive)
      : options_(options), drive_(drive) {}

  Findings Run() {
    const bool is_reached = Reach() && ShakeHands() && Call();
    if (!is_reached) {
      Add("rights, clock, map", kSkipped, "the server cannot be asked");
      return std::move(findings_);
    }
    if (AskForRights()) {
      LookAtServer();
      if (options_.map.empty()) {
        Add("map", kSkipped, "no --map is named");
      } else if (LookForMap()) {
        LookForPlaces();
        LookAtClock();
      }
    }
    return std::move(findings_);
  }

 private:
  void Add(std::string check, CheckResult result, std::string what, std::string advice = "") {
    findings_.push_back({std::move(check), result, std::move(what), std::move(advice)});
  }

  bool Reach() {
    const absl::Status status = ProbeTcp(options_.channel.server, options_.timeout);
    if (status.ok()) {
      Add("connection", kOk, absl::StrCat(options_.channel.server, " takes connections"));
      return true;
    }
    const char* advice = "is dcloc-server running, and does it listen there? (`--listen`)";
    if (absl::IsNotFound(status)) advice = "compare the host's name, and the name service";
    if (absl::IsDeadlineExceeded(status)) advice = "a firewall may drop the packets";
    Add("connection", kFailed, std::string(status.message()), advice);
    return false;
  }

  bool ShakeHands() {
    const absl::StatusOr<TlsProbe> probe = ProbeTls(options_.channel, options_.timeout);
    const bool wants_tls = !options_.channel.tls_ca.empty();
    if (!wants_tls) {
      if (!probe.ok()) {
        Add("TLS", kOk, "none: plaintext on both sides");
        return true;
      }
      Add("TLS", kFailed, "the server speaks TLS, and no --tls-ca is given",
          "give the authority of its certificate as --tls-ca");
      findings_.push_back(CertificateDates(*probe));
      return false;
    }
    if (!probe.ok()) {
      const bool is_file = absl::IsInvalidArgument(probe.status());
      Add("TLS", kFailed, std::string(probe.status().message()),
          is_file ? "" : "leave --tls-ca out, if the server speaks plaintext");
      return false;
    }
    findings_.push_back(CertificateTrust(*probe, options_.channel.tls_ca));
    findings_.push_back(CertificateDates(*probe));
    if (probe->asks_for_certificate && options_.channel.tls_cert.empty()) {
      Add("own certificate", kWarning, "the server asks for the caller's certificate",
          "give one as --tls-cert and --tls-key, if it refuses to go on without");
    }
    return probe->fault.empty();
  }

  bool Call() {
    absl::StatusOr<std::shared_ptr<grpc::Channel>> channel = client::MakeChannel(options_.channel);
    if (!channel.ok()) {
      Add("gRPC", kFailed, std::string(channel.status().message()));
      return false;
    }
    channel_ = *std::move(channel);
    if (channel_->WaitForConnected(std::chrono::system_clock::now() + options_.timeout)) {
      Add("gRPC", kOk, "is connected");
      return true;
    }
    Add("gRPC", kFailed, "no connection, though the port takes some",
        "is it dcloc-server that listens there, and does it refuse the caller's certificate?");
    return false;
  }

  bool AskForRights() {
    rights_ = AskRights(channel_, options_.timeout);
    std::vector<std::string> granted;
    for (const auto& [permission, status] : rights_.calls) {
      if (status.ok()) granted.push_back(permission);
    }
    if (const absl::Status status = rights_.Unauthenticated(); !status.ok()) {
      Add("rights", kFailed, std::string(status.message()),
          options_.channel.token_file.empty()
              ? "give a token by --token-file, which `dcloc-server token create` makes"
              : "the token is not known here, or was revoked or has expired: have a new one made");
      return false;
    }
    const std::string role = rights_.Role();
    const std::string may = absl::StrCat(role, ": may ", absl::StrJoin(granted, ", "));
    const bool is_anybody =
        options_.channel.token_file.empty() && options_.channel.tls_cert.empty();
    if (granted.empty()) {
      Add("rights", kFailed, "the caller may do nothing", "have the role of its token changed");
    } else if (!options_.map.empty() && !rights_.Grants("localize")) {
      Add("rights", kFailed, may + "; it may not localize",
          "vehicles need the role vehicle: `dcloc-server token create --role vehicle`");
    } else if (is_anybody && rights_.Grants("manage_maps")) {
      Add("rights", kWarning, absl::StrCat(may, "; so may all who reach the server"),
          "make tokens (`dcloc-server token create`): from the first one on, callers need one");
    } else {
      Add("rights", kOk, may);
    }
    return !granted.empty();
  }

  void LookAtServer() {
    const auto state = client::AdminClient(channel_, options_.timeout).ServerState();
    if (!state.ok()) return Add("server", kSkipped, "the caller may not read its state");
    const std::string what =
        absl::StrCat("dcloc-server ", state->server_version(), ", ", state->session_count(), " of ",
                     state->max_session_count(), " sessions");
    if (state->draining()) {
      Add("server", kFailed, what + "; it drains and takes no more", "restart it, or use another");
    } else if (state->session_count() >= state->max_session_count()) {
      Add("server", kFailed, what + "; it is full", "end sessions, or add a server");
    } else if (state->stub_matcher()) {
      Add("server", kFailed, what + "; its poses mean nothing",
          "start it without --stub-localizer");
    } else if (!state->certificate_fault().empty()) {
      Add("server", kWarning,
          absl::StrCat(what, "; new certificate files are not shown: ", state->certificate_fault()),
          "mend the files; the server reads them again by itself");
    } else {
      Add("server", kOk, what);
    }
  }

  /// False where there is none to go on with.
  bool LookForMap() {
    if (!rights_.Grants("read_maps")) {
      Add("map", kSkipped, "the caller may not read maps; places tell whether it is there");
      return true;
    }
    const auto map = client::MapClient(channel_, options_.timeout).Get(options_.map);
    if (!map.ok()) {
      Add("map", kFailed, std::string(map.status().message()),
          "upload it: `dcloc map upload --activate`; `dcloc map list` names those that there are");
      return false;
    }
    if (map->active_version() == 0) {
      Add("map", kFailed, absl::StrCat(options_.map, " has no active version"),
          "`dcloc map activate` one of its versions");
      return false;
    }
    Add("map", kOk, absl::StrCat(options_.map, ", version ", map->active_version(), " is active"));
    return true;
  }

  /// From a place to the nearest mapped street; nothing where there is none within `radius_m`.
  absl::StatusOr<std::optional<double>> DistanceFrom(const Eigen::Vector2d& p_map_m,
                                                     double radius_m) {
    v1::FindCoverageRequest request;
    request.mutable_map_place()->set_map_name(options_.map);
    request.mutable_map_place()->set_x_m(p_map_m.x());
    request.mutable_map_place()->set_y_m(p_map_m.y());
    request.set_radius_m(radius_m);
    const auto found = client::MapClient(channel_, options_.timeout).FindCoverage(request);
    if (!found.ok()) return found.status();
    for (const v1::MapCoverage& coverage : *found) {
      if (coverage.map_name() == options_.map) return coverage.distance_m();
    }
    return std::optional<double>();
  }

  void LookForPlaces() {
    if (options_.at_map_m) LookForPlace(*options_.at_map_m);
    if (drive_ != nullptr) LookForDrive();
  }

  void LookForPlace(const Eigen::Vector2d& place_m) {
    const auto distance_m = DistanceFrom(place_m, kFarthest_m);
    const std::string place = absl::StrFormat("(%.1f, %.1f)", place_m.x(), place_m.y());
    const char* const advice = "are the coordinates those of this map's frame?";
    if (!distance_m.ok()) {
      Add("place", kFailed, std::string(distance_m.status().message()));
    } else if (!*distance_m) {
      Add("place", kFailed, place + " is farther than 10 km from all that is mapped", advice);
    } else if (**distance_m > kNear_m) {
      Add("place", kFailed, absl::StrFormat("%s is %.0f m from mapped street", place, **distance_m),
          advice);
    } else {
      Add("place", kOk, place + " is mapped");
    }
  }

  void LookForDrive() {
    if (drive_->pose_source != PoseSource::kReference) {
      return Add("drive in map", kSkipped, "the drive has no reference poses");
    }
    std::vector<Eigen::Vector2d> places;
    for (const DriveScan& entry : drive_->scans) {
      const Eigen::Vector2d p = entry.T_map_vehicle.translation_m.head<2>();
      if (places.empty() || (p - places.back()).norm() > kBetweenPlaces_m) places.push_back(p);
    }
    const std::size_t stride = places.size() / kMaxPlaces + 1;
    std::size_t count = 0;
    std::size_t covered_count = 0;
    for (std::size_t i = 0; i < places.size(); i += stride) {
      const auto distance_m = DistanceFrom(places[i], kNear_m);
      if (!distance_m.ok()) {
        return Add("drive in map", kFailed, std::string(distance_m.status().message()));
      }
      ++count;
      covered_count += *distance_m ? 1U : 0U;
    }
    const bool is_all = covered_count == count;
    Add("drive in map",
        is_all               ? kOk
        : covered_count == 0 ? kFailed
                             : kWarning,
        absl::StrCat(covered_count, " of ", count, " places of the drive are mapped"),
        is_all ? "" : "are the drive's poses in this map's frame? map the rest of its way");
  }

  void LookAtClock() {
    if (!options_.opens_session) {
      return Add("clock", kSkipped, "a session tells it: give --open-session");
    }
    const auto offset =
        CompareClocks(channel_, options_.map, options_.vehicle, SessionRig(), options_.timeout);
    if (!offset.ok()) {
      Add("session", kFailed, std::string(offset.status().message()),
          absl::IsPermissionDenied(offset.status())
              ? "a vehicle opens sessions of its own name alone: give it as --vehicle"
              : "");
      return;
    }
    Add("session", kOk, "one was opened, and a scan was answered");
    const bool is_off = std::abs(offset->offset_s) > kClockTolerance_s + offset->bound_s;
    Add("clock", is_off ? kWarning : kOk,
        absl::StrFormat("the server's is %.0f +- %.0f ms %s this machine's",
                        1e3 * std::abs(offset->offset_s), 1e3 * offset->bound_s,
                        offset->offset_s < 0.0 ? "behind" : "before"),
        is_off ? "let both follow one source (NTP, PTP); stamps may be of another clock, but then "
                 "ages and fixes mean little"
               : "");
  }

  Rig SessionRig() const {
    if (drive_ != nullptr) return drive_->rig;
    RadarModel radar;
    radar.id = "doctor";
    radar.range_sigma_m = 0.15;
    radar.range_rate_sigma_mps = 0.12;
    radar.azimuth_sigma_rad = 0.02;
    return {.radars = {radar}};
  }

  const ServerCheckOptions& options_;
  const Drive* const drive_;
  std::shared_ptr<grpc::Channel> channel_;
  Rights rights_;
  Findings findings_;
};

}  // namespace

Findings CheckServer(const ServerCheckOptions& options, const Drive* drive) {
  return ServerExamination(options, drive).Run();
}

}  // namespace dcloc::cli
