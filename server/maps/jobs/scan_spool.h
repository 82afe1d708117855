#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "dcloc/v1/map_service.pb.h"
#include "server/base/sha256.h"

namespace dcloc::server {

/// What a client sends to have a map built, as a file (FramedReader): the header, then drives and
/// scans in the order in which they came. The file is removed with this object, if it is still
/// there. Not thread-safe.
class ScanSpool {
 public:
  /// Makes the file in `folder`.
  static absl::StatusOr<std::unique_ptr<ScanSpool>> Create(const std::filesystem::path& folder);
  ~ScanSpool();
  ScanSpool(const ScanSpool&) = delete;
  ScanSpool& operator=(const ScanSpool&) = delete;

  /// ResourceExhausted when the disk is full, or when the file would have more than `max_bytes`.
  absl::Status Append(const v1::StartMapBuildRequest& message, std::int64_t max_bytes);

  /// Ends writing; gives the hash of the file.
  absl::StatusOr<std::string> Finish();

  const std::filesystem::path& path() const { return path_; }

 private:
  explicit ScanSpool(std::filesystem::path path);

  std::filesystem::path path_;
  std::ofstream out_;
  std::string buffer_;
  Sha256 hash_;
  std::int64_t size_bytes_ = 0;
};

}  // namespace dcloc::server
