#include "server/maps/service/build_stream.h"

#include <cstdint>
#include <utility>

#include "spdlog/spdlog.h"

namespace dcloc::server {

BuildStream* BuildStream::Start(grpc::CallbackServerContext* context, const RpcContext& host,
                                MapBuilds& builds, grpc::ByteBuffer* response) {
  return Begin(std::shared_ptr<BuildStream>(new BuildStream(host, context, builds, response)));
}

BuildIntake& BuildStream::intake() {
  if (!intake_) {
    intake_.emplace(host().store.incoming().folder(),
                    std::int64_t{host().limits.max_map_mib} << 20);
  }
  return *intake_;
}

absl::Status BuildStream::Take(const v1::StartMapBuildRequest& request) {
  return intake().Take(request);
}

absl::Status BuildStream::Complete(v1::StartMapBuildResponse* response) {
  absl::StatusOr<BuildInput> input = intake().Finish();
  if (!input.ok()) return input.status();
  absl::StatusOr<v1::MapBuild> build = builds_.Start(principal().tenant, *std::move(input));
  if (!build.ok()) return build.status();
  *response->mutable_build() = *std::move(build);
  spdlog::info("map build started build={} map={} scans={}", response->build().build_id(),
               response->build().map_name(), response->build().scan_count());
  return absl::OkStatus();
}

}  // namespace dcloc::server
