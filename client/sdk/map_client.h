#pragma once

#include <grpcpp/channel.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "dcloc/v1/map_service.grpc.pb.h"

namespace dcloc::client {

/// Manages the maps of a server. Calls block, each for `timeout` at most; errors are the server's
/// own, or Unavailable and DeadlineExceeded when it cannot be reached. Thread-safe.
class MapClient {
 public:
  explicit MapClient(const std::shared_ptr<grpc::Channel>& channel,
                     std::chrono::milliseconds timeout = std::chrono::seconds(15));

  /// Called between chunks while a file is uploaded.
  using UploadProgress = std::function<void(std::int64_t sent_bytes, std::int64_t size_bytes)>;

  /// Adds the map file as a new version, and the map if it is new. On top of `timeout` it may take
  /// as long as the file does at 1 MB/s.
  absl::StatusOr<v1::MapVersion> Upload(const std::filesystem::path& file,
                                        const std::string& map_name, bool activate,
                                        const UploadProgress& progress = {});

  /// All maps, by name.
  absl::StatusOr<std::vector<v1::Map>> List();

  /// All versions of a map, newest first.
  absl::StatusOr<std::vector<v1::MapVersion>> ListVersions(const std::string& map_name);

  absl::StatusOr<v1::Map> Get(const std::string& map_name);

  /// `version` 0 is the active one.
  absl::StatusOr<v1::MapVersion> GetVersion(const std::string& map_name, std::int64_t version);

  /// New sessions get this version.
  absl::StatusOr<v1::Map> Activate(const std::string& map_name, std::int64_t version);

  absl::Status DeleteVersion(const std::string& map_name, std::int64_t version);

  /// Deletes the map with all of its versions.
  absl::Status Delete(const std::string& map_name);

 private:
  std::unique_ptr<v1::MapService::Stub> stub_;
  std::chrono::milliseconds timeout_;
};

}  // namespace dcloc::client
