#include "server/maps/service/build_stream.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/base/check.h"
#include "server/base/status.h"
#include "server/convert/geometry.h"
#include "server/convert/scan.h"
#include "server/maps/jobs/map_build.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {

BuildStream* BuildStream::Start(grpc::CallbackServerContext* context, const RpcContext& host,
                                MapBuilds& builds, grpc::ByteBuffer* response) {
  return Begin(std::shared_ptr<BuildStream>(new BuildStream(host, context, builds, response)));
}

absl::Status BuildStream::Take(const v1::StartMapBuildRequest& request) {
  if (!build_) return request.has_header() ? TakeHeader(request.header()) : Missing("header");
  return request.has_scan() ? Append(request.scan()) : Missing("scan");
}

absl::Status BuildStream::Complete(v1::StartMapBuildResponse* response) {
  if (!build_) return Missing("header");
  if (scans_->scan_count() == 0) return Missing("scan");
  const absl::StatusOr<BuildRecord> record = builds_.Start(*std::move(build_), std::move(scans_));
  if (!record.ok()) return record.status();
  ToProto(*record, response->mutable_build());
  spdlog::info("map build started build={} map={} scans={}", record->build_id, record->map_name,
               record->scan_count);
  return absl::OkStatus();
}

absl::Status BuildStream::TakeHeader(const v1::MapBuildHeader& header) {
  absl::StatusOr<BuildRequest> request = FromProto(header);
  if (!request.ok()) return request.status();
  request->tenant = principal().tenant;
  request->limits = {.max_map_bytes = std::int64_t{host().limits.max_map_mib} << 20,
                     .max_tenant_bytes = std::int64_t{host().limits.max_tenant_storage_mib} << 20};
  absl::StatusOr<std::unique_ptr<ScanSpool>> scans =
      ScanSpool::Create(host().store.incoming().folder());
  if (!scans.ok()) return scans.status();
  scans_ = *std::move(scans);
  build_ = *std::move(request);
  return absl::OkStatus();
}

absl::Status BuildStream::Append(const v1::PosedScan& message) {
  const std::string prefix = absl::StrCat("scan ", scans_->scan_count(), ": ");
  absl::Status status =
      WithPrefix("scan.", convert::FromProto(message.scan(), build_->rig, &scan_));
  if (status.ok() && !message.has_t_map_vehicle()) status = Missing("t_map_vehicle");
  if (status.ok()) status = convert::FromProto(message.t_map_vehicle(), "t_map_vehicle").status();
  if (message.begins_pass()) last_stamp_.reset();
  if (status.ok() && last_stamp_ && scan_.stamp < *last_stamp_) {
    status = absl::InvalidArgumentError(
        absl::StrFormat("scan.stamp_ns is %d; it must not lie before %d, the scan's before it",
                        message.scan().stamp_ns(), last_stamp_->time_since_epoch().count()));
  }
  if (!status.ok()) return WithPrefix(prefix, status);
  last_stamp_ = scan_.stamp;
  return scans_->Append(message, build_->limits.max_map_bytes);
}

}  // namespace dcloc::server
