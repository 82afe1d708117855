#include "server/maps/jobs/upload.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "absl/strings/str_format.h"
#include "server/base/check.h"
#include "server/base/status.h"
#include "server/convert/map.h"
#include "server/identity/principal.h"
#include "server/maps/store/read_map.h"

namespace dcloc::server {
namespace {

constexpr std::int64_t kMaxChunk_bytes = 1 << 20;

absl::Status Validate(const UploadRequest& request, std::int64_t max_size_bytes) {
  absl::Status status = CheckMapName("header.map_name", request.map_name);
  status.Update(CheckIntegerBetween("header.size_bytes", request.size_bytes, 1, max_size_bytes));
  status.Update(convert::CheckSha256("header.sha256", request.sha256));
  return status;
}

absl::StatusOr<std::shared_ptr<const RadarMap>> VerifyMap(const std::filesystem::path& path,
                                                          absl::string_view sha256) {
  absl::StatusOr<std::shared_ptr<const RadarMap>> map = ReadMap(path, sha256);
  if (!absl::IsDataLoss(map.status())) return map;
  return WithPrefix("the file is no intact map: ", map.status());
}

}  // namespace

Upload::Upload(MapStore& store, UploadRequest request, Hold room, IncomingFile file)
    : store_(&store),
      request_(std::move(request)),
      room_(std::move(room)),
      file_(std::move(file)) {}

absl::StatusOr<Upload> Upload::Begin(MapStore& store, UploadRequest request,
                                     const UploadLimits& limits) {
  if (absl::Status status = Validate(request, limits.max_map_bytes); !status.ok()) return status;
  absl::StatusOr<Hold> room = store.quota().Reserve({.tenant = request.tenant,
                                                     .prefix = ScopedMapName(request.tenant, ""),
                                                     .sha256 = request.sha256,
                                                     .size_bytes = request.size_bytes},
                                                    limits.max_tenant_bytes);
  if (!room.ok()) return room.status();
  IncomingFile file = store.incoming().Take(request.tenant, request.sha256);
  return Upload(store, std::move(request), *std::move(room), std::move(file));
}

absl::Status Upload::Append(std::int64_t offset_bytes, absl::string_view bytes) {
  const absl::StatusOr<IncomingFile::Hold> hold = file_.Lock();
  if (!hold.ok()) return hold.status();
  if (!file_.begun()) {
    if (absl::Status status = BeginAt(offset_bytes); !status.ok()) return status;
  }
  if (offset_bytes != file_.hashed_bytes()) {
    return absl::InvalidArgumentError(
        absl::StrFormat("chunk.offset_bytes is %d; the bytes before it end at %d", offset_bytes,
                        file_.hashed_bytes()));
  }
  absl::Status status =
      CheckIntegerBetween("the size of chunk.data", static_cast<std::int64_t>(bytes.size()), 0,
                          std::min(kMaxChunk_bytes, request_.size_bytes - offset_bytes));
  return status.ok() ? file_.Write(bytes) : status;
}

absl::Status Upload::BeginAt(std::int64_t offset_bytes) {
  const absl::StatusOr<std::int64_t> size = file_.Size();
  if (!size.ok()) return size.status();
  if (offset_bytes < 0 || offset_bytes > std::min(*size, request_.size_bytes)) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "chunk.offset_bytes is %d; of this file %d bytes are here", offset_bytes, *size));
  }
  return file_.BeginAt(offset_bytes);
}

absl::StatusOr<MapVersionRecord> Upload::Finish() {
  absl::StatusOr<LoadedMap> taken = Take();
  if (!taken.ok()) return taken.status();
  MapVersionRecord record = std::move(taken->record);
  if (!request_.activate) return record;
  // Held meanwhile, so that what has just been verified is not once more.
  const absl::StatusOr<MapRecord> map = store_->Activate(record.map_name, record.version);
  if (!map.ok()) return map.status();
  record.active = map->active_version == record.version;
  return record;
}

absl::StatusOr<LoadedMap> Upload::Take() {
  const absl::StatusOr<IncomingFile::Hold> hold = file_.Lock();
  if (!hold.ok()) return hold.status();
  const std::string map_name = ScopedMapName(request_.tenant, request_.map_name);
  if (!file_.begun()) {
    absl::StatusOr<MapVersionRecord> stored =
        store_->AddStored(ScopedMapName(request_.tenant, ""), map_name, request_.sha256);
    if (stored.ok()) return LoadedMap{.record = *std::move(stored), .map = nullptr};
    if (!absl::IsNotFound(stored.status())) return stored.status();
  }
  const absl::StatusOr<std::int64_t> size = file_.Size();
  if (!size.ok()) return size.status();
  if (*size != request_.size_bytes) {
    return absl::DataLossError(
        absl::StrFormat("%d bytes came; header.size_bytes is %d", *size, request_.size_bytes));
  }
  if (!file_.begun()) {
    if (absl::Status status = file_.BeginAt(*size); !status.ok()) return status;
  }
  const absl::StatusOr<std::string> sha256 = file_.Finish();
  if (!sha256.ok()) {
    // What a sync did not write may be gone, though it can be read until it leaves the memory.
    file_.Remove().IgnoreError();
    return sha256.status();
  }
  if (*sha256 != request_.sha256) {
    file_.Remove().IgnoreError();
    return absl::DataLossError(absl::StrFormat(
        "the bytes that came have the hash %s; header.sha256 is %s", *sha256, request_.sha256));
  }
  absl::StatusOr<std::shared_ptr<const RadarMap>> map = VerifyMap(file_.path(), *sha256);
  if (!map.ok()) {
    if (absl::IsDataLoss(map.status())) file_.Remove().IgnoreError();
    return map.status();
  }
  return store_->Add(file_.path(), map_name, *sha256, *std::move(map));
}

}  // namespace dcloc::server
