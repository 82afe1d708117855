#pragma once

#include <memory>
#include <optional>

#include "dcloc/v1/map_service.pb.h"
#include "server/maps/jobs/map_builds.h"
#include "server/rpc/read_stream.h"

namespace dcloc::server {

/// One StartMapBuild call: each message is checked and written to disk before the next one is read.
class BuildStream final : public ReadStream<v1::StartMapBuildRequest, v1::StartMapBuildResponse> {
 public:
  static BuildStream* Start(grpc::CallbackServerContext* context, const RpcContext& host,
                            MapBuilds& builds, grpc::ByteBuffer* response);

 private:
  BuildStream(const RpcContext& host, grpc::CallbackServerContext* context, MapBuilds& builds,
              grpc::ByteBuffer* response)
      : ReadStream(host, context, response), builds_(builds) {}

  absl::Status Take(const v1::StartMapBuildRequest& request) override;
  absl::Status Complete(v1::StartMapBuildResponse* response) override;
  void Release() override { intake_.reset(); }

  BuildIntake& intake();

  MapBuilds& builds_;
  std::optional<BuildIntake> intake_;
};

}  // namespace dcloc::server
