#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "absl/status/statusor.h"
#include "dcloc/v1/map_service.grpc.pb.h"

namespace dcloc::client {

/// How far a file is on its way.
using TransferProgress = std::function<void(std::int64_t done_bytes, std::int64_t size_bytes)>;

struct UploadOptions {
  bool activate = false;  ///< new sessions get the version at once
  /// When the connection breaks, the upload goes on where the server has it, until there has been
  /// no progress for so long.
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
