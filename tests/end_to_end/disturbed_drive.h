#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <limits>

#include "absl/status/status.h"
#include "client/sdk/session.h"
#include "dcloc/v1/localization_service.pb.h"
#include "dcloc/v1/scan.pb.h"
#include "tests/end_to_end/session_site.h"

namespace dcloc {

/// The scans of a drive, and what becomes of their answers.
struct DriveScans {
  int count = 0;
  std::function<v1::Scan(int index)> at;
  std::function<void(v1::LocalizeResponse answer)> take;
};

/// What befalls a drive, and when: at random moments, each of them once the vehicle has got over
/// the one before.
struct Disturbances {
  int cut_count = 0;  ///< of all connections
  int restart_count = 0;
  /// Whether each other restart is by SIGKILL, and not by SIGTERM.
  enum class Restarts { kBySigterm, kInTurn } restarts = Restarts::kBySigterm;
  unsigned seed = 1;
};

/// How a vehicle got over what befell it.
struct Recoveries {
  std::chrono::duration<double> longest{};  ///< from a cut, or a restart's end, to the next session
  client::SessionStats stats;
};

/// How a session is opened that is to get over disturbances; without `reconnect`, an undisturbed
/// one.
client::SessionOptions CampaignOptions();

/// The number of the scan that it answers.
std::int64_t NumberOf(const v1::LocalizeResponse& answer);

/// Sends all scans and takes their answers: one to each, in order, or an error.
absl::Status DriveUndisturbed(client::Session& session, const DriveScans& scans);

/// The same through what befalls `site`. An error too where the session was not resumed after each
/// cut and begun anew after each restart, within five seconds.
absl::Status DriveDisturbed(client::Session& session, const DriveScans& scans, SessionSite& site,
                            const Disturbances& disturbances, Recoveries& recoveries);

}  // namespace dcloc
