#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"
#include "dcloc/v1/map_service.pb.h"
#include "server/maps/jobs/scan_spool.h"

namespace dcloc::server {

/// What is to be built, whole and checked.
struct BuildInput {
  std::string map_name;  ///< without the tenant
  v1::MapBuildMethod method = v1::MAP_BUILD_METHOD_UNSPECIFIED;
  std::int64_t scan_count = 0;
  std::unique_ptr<ScanSpool> spool;
  std::string sha256;  ///< of the spool
};

/// Takes in what a client sends to have a map built. Each message is checked as it comes, and
/// written to disk. InvalidArgument names the drive, the scan and the field; ResourceExhausted as
/// of `ScanSpool`. Not thread-safe.
class BuildIntake {
 public:
  /// The spool's file is in `folder`, with at most `max_bytes`.
  BuildIntake(std::filesystem::path folder, std::int64_t max_bytes)
      : folder_(std::move(folder)), max_bytes_(max_bytes) {}

  absl::Status Take(const v1::StartMapBuildRequest& message);

  /// After the last message.
  absl::StatusOr<BuildInput> Finish();

 private:
  absl::Status TakeHeader(const v1::MapBuildHeader& header);
  absl::Status TakeDrive(const v1::MapBuildDrive& drive);
  absl::Status TakeScan(const v1::PosedScan& scan);
  absl::Status CheckScan(const v1::PosedScan& scan);
  bool is_survey() const { return input_.method == v1::MAP_BUILD_METHOD_SURVEY; }
  bool is_update() const { return input_.method == v1::MAP_BUILD_METHOD_UPDATE; }
  /// "scan 3: ", or in a survey "drive \"b\", scan 3: ".
  std::string Where() const;
  /// InvalidArgument unless the present drive has scans.
  absl::Status CheckDriveHasScans() const;

  const std::filesystem::path folder_;
  const std::int64_t max_bytes_;
  bool has_header_ = false;
  BuildInput input_;
  Rig rig_;            ///< of the scans that come now
  std::string drive_;  ///< likewise, in a survey
  std::set<std::string> drives_;
  std::int64_t drive_scan_count_ = 0;
  std::optional<Stamp> last_stamp_;
  Scan scan_;  ///< kept for its columns' memory
};

}  // namespace dcloc::server
