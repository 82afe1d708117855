#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "dcloc/v1/map_service.pb.h"

namespace dcloc::server {

/// The scans of a map build, in a file that is removed with this object. Not thread-safe.
class ScanSpool {
 public:
  /// Makes the file in `folder`.
  static absl::StatusOr<std::unique_ptr<ScanSpool>> Create(const std::filesystem::path& folder);
  ~ScanSpool();
  ScanSpool(const ScanSpool&) = delete;
  ScanSpool& operator=(const ScanSpool&) = delete;

  /// ResourceExhausted when the disk is full, or when the file would have more than `max_bytes`.
  absl::Status Append(const v1::PosedScan& scan, std::int64_t max_bytes);

  /// Ends writing. `Next` then gives the scans in the order in which they came; once more from the
  /// first one with each call.
  absl::Status BeginReading();

  /// False after the last one.
  absl::StatusOr<bool> Next(v1::PosedScan* scan);

  std::int64_t scan_count() const { return scan_count_; }

 private:
  explicit ScanSpool(std::filesystem::path path);

  std::filesystem::path path_;
  std::ofstream out_;
  std::ifstream in_;
  std::string buffer_;
  std::int64_t scan_count_ = 0;
  std::int64_t size_bytes_ = 0;
};

}  // namespace dcloc::server
