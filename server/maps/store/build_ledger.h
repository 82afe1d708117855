#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/base/clock.h"

namespace dcloc::server {

/// What the next process must know of a running build.
struct LedgerEntry {
  std::string tenant;
  std::string build_id;
  std::string map_name;
  std::int64_t scan_count = 0;
  SystemTime create_time;
};

/// The running builds, a small file each, so that after a restart their clients can be told that
/// they failed. Thread-safe.
class BuildLedger {
 public:
  /// Makes the folder if it is not there.
  static absl::StatusOr<std::unique_ptr<BuildLedger>> Open(const std::filesystem::path& folder);

  /// Returns and removes the builds that an earlier process has not ended, the oldest first.
  const std::vector<LedgerEntry>& interrupted() const { return interrupted_; }

  /// Durable when it returns.
  absl::Status Add(const LedgerEntry& entry) const;

  /// The build has ended.
  void Remove(absl::string_view build_id) const;

 private:
  explicit BuildLedger(std::filesystem::path folder) : folder_(std::move(folder)) {}

  std::filesystem::path PathOf(absl::string_view build_id) const;

  const std::filesystem::path folder_;
  std::vector<LedgerEntry> interrupted_;
};

}  // namespace dcloc::server
