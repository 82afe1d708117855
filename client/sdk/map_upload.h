#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "absl/status/statusor.h"
#include "dcloc/v1/map_service.grpc.pb.h"

namespace dcloc::client {

/// The progress of a transfer.
using TransferProgress = std::function<void(std::int64_t done_bytes, std::int64_t size_bytes)>;

struct UploadOptions {
  bool activate = false;  ///< new sessions get the version at once
  /// After the connection breaks, the upload continues from the bytes that the server has. It gives
  /// up after this time without progress.
  std::chrono::milliseconds give_up_after = std::chrono::minutes(1);
  TransferProgress progress;  ///< called between chunks
};

/// As MapClient::Upload. `timeout` is that of a call.
absl::StatusOr<v1::MapVersion> UploadMapFile(v1::MapService::Stub& stub,
                                             const std::filesystem::path& file,
                                             const std::string& map_name,
                                             const UploadOptions& options,
                                             std::chrono::milliseconds timeout);

}  // namespace dcloc::client
