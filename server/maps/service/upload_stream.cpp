#include "server/maps/service/upload_stream.h"

#include <utility>

#include "server/base/check.h"
#include "server/convert/map.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {

UploadStream* UploadStream::Start(grpc::CallbackServerContext* context, const RpcContext& host,
                                  grpc::ByteBuffer* response) {
  return Begin(std::shared_ptr<UploadStream>(new UploadStream(host, context, response)));
}

absl::Status UploadStream::Take(const v1::UploadMapRequest& request) {
  if (!upload_) return request.has_header() ? TakeHeader(request.header()) : Missing("header");
  if (!request.has_chunk()) return Missing("chunk");
  return upload_->Append(request.chunk().offset_bytes(), request.chunk().data());
}

absl::Status UploadStream::Complete(v1::UploadMapResponse* response) {
  if (!upload_) return Missing("header");
  const absl::StatusOr<MapVersionRecord> record = upload_->Finish();
  if (!record.ok()) return record.status();
  convert::ToProto(*record, response->mutable_version());
  spdlog::info("map uploaded map={} version={} bytes={} active={}", record->map_name,
               record->version, record->info.size_bytes, record->active);
  return absl::OkStatus();
}

absl::Status UploadStream::TakeHeader(const v1::UploadMapHeader& header) {
  const Limits& limits = host().limits;
  absl::StatusOr<Upload> upload =
      Upload::Begin(host().store,
                    {.tenant = principal().tenant,
                     .map_name = header.map_name(),
                     .size_bytes = header.size_bytes(),
                     .sha256 = header.sha256(),
                     .activate = header.activate()},
                    {.max_map_bytes = std::int64_t{limits.max_map_mib} << 20,
                     .max_tenant_bytes = std::int64_t{limits.max_tenant_storage_mib} << 20});
  if (!upload.ok()) return upload.status();
  upload_.emplace(*std::move(upload));
  return absl::OkStatus();
}

}  // namespace dcloc::server
