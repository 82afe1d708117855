#pragma once

#include <filesystem>

#include "absl/status/statusor.h"
#include "client/sdk/map_upload.h"
#include "dcloc/v1/map_service.grpc.pb.h"

namespace dcloc::client {

/// As MapClient::Download.
absl::StatusOr<v1::MapVersion> DownloadMapFile(v1::MapService::Stub& stub,
                                               const v1::DownloadMapRequest& request,
                                               const std::filesystem::path& file,
                                               const TransferProgress& progress);

}  // namespace dcloc::client
