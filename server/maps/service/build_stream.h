#pragma once

#include <grpcpp/server_context.h>

#include <memory>
#include <optional>

#include "core/radar/scan.h"
#include "dcloc/v1/map_service.pb.h"
#include "server/maps/jobs/map_builds.h"
#include "server/rpc/storage_host.h"

namespace dcloc::server {

/// One StartMapBuild call: each scan is read, checked and written to disk on the call's strand.
/// Only then is the next one read.
class BuildStream final : public grpc::ServerReadReactor<v1::StartMapBuildRequest>,
                          public std::enable_shared_from_this<BuildStream> {
 public:
  /// Lives until the call is done and the pool has let go of it.
  static BuildStream* Start(grpc::CallbackServerContext* context, const StorageHost& host,
                            MapBuilds& builds, v1::StartMapBuildResponse* response);

  void OnReadDone(bool ok) override;
  void OnDone() override;

 private:
  BuildStream(grpc::CallbackServerContext* context, const StorageHost& host, MapBuilds& builds,
              v1::StartMapBuildResponse* response);

  void TakeMessage();
  void TakeEnd();
  absl::Status Take(const v1::StartMapBuildRequest& request);
  absl::Status Begin(const v1::MapBuildHeader& header);
  absl::Status Append(const v1::PosedScan& scan);

  grpc::CallbackServerContext* context_;
  const StorageHost& host_;
  MapBuilds& builds_;
  OpenCalls::Token token_;
  Strand strand_;
  v1::StartMapBuildResponse* response_;
  std::shared_ptr<BuildStream> self_;  ///< reset by OnDone
  v1::StartMapBuildRequest request_;
  std::optional<BuildRequest> build_;
  std::unique_ptr<ScanSpool> scans_;
  Scan scan_;  ///< kept for its columns' memory
  std::optional<Stamp> last_stamp_;
};

}  // namespace dcloc::server
