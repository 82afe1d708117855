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

BuildStream* BuildStream::Start(grpc::CallbackServerContext* context, const StorageHost& host,
                                MapBuilds& builds, v1::StartMapBuildResponse* response) {
  std::shared_ptr<BuildStream> stream(new BuildStream(context, host, builds, response));
  stream->self_ = stream;
  stream->StartRead(&stream->request_);
  return stream.get();
}

BuildStream::BuildStream(grpc::CallbackServerContext* context, const StorageHost& host,
                         MapBuilds& builds, v1::StartMapBuildResponse* response)
    : context_(context),
      host_(host),
      builds_(builds),
      token_(host.open_calls),
      strand_(host.pool),
      response_(response) {
  strand_.SetLane(Lane::kLengthy);
}

void BuildStream::OnReadDone(bool ok) {
  if (ok) {
    strand_.Post([self = shared_from_this()] { self->TakeMessage(); });
  } else {
    strand_.Post([self = shared_from_this()] { self->TakeEnd(); });
  }
}

void BuildStream::OnDone() { const std::shared_ptr<BuildStream> last = std::move(self_); }

void BuildStream::TakeMessage() {
  if (const absl::Status status = Take(request_); !status.ok()) {
    scans_.reset();
    Finish(ToGrpc(status));
    return;
  }
  StartRead(&request_);
}

void BuildStream::TakeEnd() {
  if (context_->IsCancelled()) {
    scans_.reset();
    Finish(grpc::Status(grpc::StatusCode::CANCELLED, "cancelled"));
    return;
  }
  absl::Status status;
  if (!build_) status = Missing("header");
  if (build_ && scans_->scan_count() == 0) status = Missing("scan");
  if (status.ok()) {
    const absl::StatusOr<BuildRecord> record = builds_.Start(*std::move(build_), std::move(scans_));
    status = record.status();
    if (record.ok()) {
      ToProto(*record, response_->mutable_build());
      spdlog::info("map build started build={} map={} scans={}", record->build_id, record->map_name,
                   record->scan_count);
    }
  }
  scans_.reset();
  Finish(ToGrpc(status));
}

absl::Status BuildStream::Take(const v1::StartMapBuildRequest& request) {
  if (!build_) return request.has_header() ? Begin(request.header()) : Missing("header");
  return request.has_scan() ? Append(request.scan()) : Missing("scan");
}

absl::Status BuildStream::Begin(const v1::MapBuildHeader& header) {
  absl::StatusOr<Principal> principal =
      host_.access.Authorize(*context_, v1::StartMapBuildRequest::descriptor());
  if (!principal.ok()) return principal.status();
  absl::StatusOr<BuildRequest> request = FromProto(header);
  if (!request.ok()) return request.status();
  request->tenant = std::move(principal->tenant);
  request->limits = {.max_map_bytes = std::int64_t{host_.limits.max_map_mib} << 20,
                     .max_tenant_bytes = std::int64_t{host_.limits.max_tenant_storage_mib} << 20};
  absl::StatusOr<std::unique_ptr<ScanSpool>> scans =
      ScanSpool::Create(host_.store.incoming().folder());
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
