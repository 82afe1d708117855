#include "server/maps/service/upload_stream.h"

#include <utility>

#include "server/base/check.h"
#include "server/base/status.h"
#include "server/convert/map.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {

UploadStream* UploadStream::Start(grpc::CallbackServerContext* context, const StorageHost& host,
                                  v1::UploadMapResponse* response) {
  std::shared_ptr<UploadStream> stream(new UploadStream(context, host, response));
  stream->self_ = stream;
  stream->StartRead(&stream->request_);
  return stream.get();
}

UploadStream::UploadStream(grpc::CallbackServerContext* context, const StorageHost& host,
                           v1::UploadMapResponse* response)
    : context_(context),
      host_(host),
      token_(host.open_calls),
      strand_(host.pool),
      response_(response) {
  strand_.SetLane(Lane::kLengthy);
}

void UploadStream::OnReadDone(bool ok) {
  if (ok) {
    strand_.Post([self = shared_from_this()] { self->TakeMessage(); });
  } else {
    strand_.Post([self = shared_from_this()] { self->TakeEnd(); });
  }
}

void UploadStream::OnDone() { const std::shared_ptr<UploadStream> last = std::move(self_); }

void UploadStream::TakeMessage() {
  if (const absl::Status status = Take(request_); !status.ok()) {
    upload_.reset();
    Finish(ToGrpc(status));
    return;
  }
  StartRead(&request_);
}

void UploadStream::TakeEnd() {
  if (context_->IsCancelled()) {
    upload_.reset();
    Finish(grpc::Status(grpc::StatusCode::CANCELLED, "cancelled"));
    return;
  }
  if (!upload_) {
    Finish(ToGrpc(Missing("header")));
    return;
  }
  const absl::StatusOr<MapVersionRecord> record = upload_->Finish();
  if (record.ok()) {
    convert::ToProto(*record, response_->mutable_version());
    spdlog::info("map uploaded map={} version={} bytes={} active={}", record->map_name,
                 record->version, record->info.size_bytes, record->active);
  }
  // Its room is given back before the client hears of the end, who may then begin the next one.
  upload_.reset();
  Finish(ToGrpc(record.status()));
}

absl::Status UploadStream::Take(const v1::UploadMapRequest& request) {
  if (!upload_) return request.has_header() ? Begin(request.header()) : Missing("header");
  if (!request.has_chunk()) return Missing("chunk");
  return upload_->Append(request.chunk().offset_bytes(), request.chunk().data());
}

absl::Status UploadStream::Begin(const v1::UploadMapHeader& header) {
  const absl::StatusOr<Principal> principal =
      host_.access.Authorize(*context_, v1::UploadMapRequest::descriptor());
  if (!principal.ok()) return principal.status();
  absl::StatusOr<Upload> upload =
      Upload::Begin(host_.store,
                    {.tenant = principal->tenant,
                     .map_name = header.map_name(),
                     .size_bytes = header.size_bytes(),
                     .sha256 = header.sha256(),
                     .activate = header.activate()},
                    {.max_map_bytes = std::int64_t{host_.limits.max_map_mib} << 20,
                     .max_tenant_bytes = std::int64_t{host_.limits.max_tenant_storage_mib} << 20});
  if (!upload.ok()) return upload.status();
  upload_.emplace(*std::move(upload));
  return absl::OkStatus();
}

}  // namespace dcloc::server
