#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/base/clock.h"

namespace dcloc::server {

enum class BuildState { kRunning, kDone, kFailed, kCancelled };

/// A build of a map version, as others see it. It is running from its start, also while it waits.
struct BuildRow {
  std::string build_id;
  std::string tenant;
  std::string map_name;  ///< without the tenant
  BuildState state = BuildState::kRunning;
  SystemTime create_time;
  std::string input_sha256;        ///< of the file that says what to build
  std::string report;              ///< how far it is, or what came out; bytes of its builder's
  std::int64_t attempt_count = 0;  ///< how often a server began it
};

/// A build that a server has taken, until it ends it or loses it.
struct BuildLease {
  std::string build_id;
  std::string holder;        ///< names the process
  std::int64_t attempt = 0;  ///< tells it from a later lease of the same build
};

/// What a builder learns when it renews its lease.
enum class LeaseState {
  kHeld,
  kCancelled,  ///< still held; the build is to end without a version
  kLost,       ///< another one may build it now
};

/// Builds that wait for a server or are under way, and the last ones that have ended. Several
/// servers may share one queue if its implementation says so; each build is taken by one of them.
/// A server that dies loses what it has taken, and another one takes it. Thread-safe; calls may
/// block on storage, with the errors of `Catalogue`.
class BuildQueue {
 public:
  /// Builds of a tenant that have ended, of which the queue keeps the last ones.
  static constexpr int kMaxEnded = 200;
  /// A build that so many servers began and none ended is given up: it may be what ends them.
  static constexpr int kMaxAttempts = 3;

  virtual ~BuildQueue() = default;

  /// ResourceExhausted when the tenant has `max_running` already.
  virtual absl::Status Add(const BuildRow& row, int max_running) = 0;

  /// NotFound: the tenant has no such build, or it ended too long ago.
  virtual absl::StatusOr<BuildRow> Get(absl::string_view tenant, absl::string_view build_id) = 0;

  /// The tenant's, newest first.
  virtual absl::StatusOr<std::vector<BuildRow>> List(absl::string_view tenant) = 0;

  /// The ids of those that run or wait, of all tenants.
  virtual absl::StatusOr<std::vector<std::string>> ListRunning() = 0;

  /// Cancels a build, unless it has ended. One that waits ends at once; one that is built is told
  /// when its lease is renewed. NotFound as above.
  virtual absl::StatusOr<BuildRow> Cancel(absl::string_view tenant, absl::string_view build_id) = 0;

  /// Takes the build that has waited longest, or was lost; nothing when there is none. A holder
  /// builds one at a time: what it still holds it has lost, now or when the lease ends.
  virtual absl::StatusOr<std::optional<BuildRow>> Take(absl::string_view holder) = 0;

  /// To be called every few seconds, and before what comes out is stored.
  virtual absl::StatusOr<LeaseState> Renew(const BuildLease& lease, absl::string_view report) = 0;

  /// The build has ended so. False when the lease was lost: then nothing is changed.
  virtual absl::StatusOr<bool> End(const BuildLease& lease, BuildState state,
                                   absl::string_view report) = 0;

  /// Its server stops: another one may take it at once, and this attempt does not count.
  virtual absl::Status GiveBack(const BuildLease& lease) = 0;
};

/// What implementations say alike.
absl::Status NoSuchBuild(absl::string_view build_id);
absl::Status TooManyBuilds(int max_running);

}  // namespace dcloc::server
