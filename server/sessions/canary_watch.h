#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include "server/maps/store/map_store.h"
#include "server/sessions/session_registry.h"
#include "server/sessions/version_trial.h"

namespace dcloc::server {

/// Watches how vehicles do in the canary of a map, beside those in the active version, and
/// withdraws the canary when they do worse (`CompareVersions`): new sessions then get the active
/// version, and running ones move to it. Vehicles that asked for a version do not count. Each
/// server judges by its own vehicles; what it withdraws is withdrawn for all. Not thread-safe but
/// for `withdrawn_count`.
class CanaryWatch {
 public:
  /// `registry` and `store` outlive it.
  CanaryWatch(SessionRegistry& registry, MapStore& store, const TrialOptions& options = {})
      : registry_(registry), store_(store), options_(options) {}

  /// Looks at every session once; to be called once a second or so.
  void Look();

  /// Judges all canaries by the looks so far, and withdraws those that are worse. Calls block on
  /// storage.
  void Judge();

  std::int64_t withdrawn_count() const { return withdrawn_count_; }

 private:
  /// What was seen of a map since its versions became what they are.
  struct Watched {
    std::string tenant;
    std::string map_name;  ///< without the tenant
    std::int64_t active_version = 0;
    std::int64_t canary_version = 0;
    std::map<std::int64_t, VersionTally> versions;
  };

  bool IsOver(const std::string& scoped_name, Watched& watched) const;
  bool Withdraw(const std::string& scoped_name, const Watched& watched, const Trial& trial);

  SessionRegistry& registry_;
  MapStore& store_;
  const TrialOptions options_;
  std::map<std::string, Watched> maps_;  ///< by their names with the tenant
  std::atomic<std::int64_t> withdrawn_count_ = 0;
};

}  // namespace dcloc::server
