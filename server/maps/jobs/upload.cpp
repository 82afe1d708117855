#include "server/maps/jobs/upload.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/strip.h"
#include "server/base/check.h"
#include "server/convert/map.h"
#include "server/identity/principal.h"

namespace dcloc::server {
namespace {

constexpr std::int64_t kMaxChunk_bytes = 1 << 20;

absl::Status Validate(const UploadRequest& request, std::int64_t max_size_bytes) {
  absl::Status status = CheckMapName("header.map_name", request.map_name);
  status.Update(CheckIntegerBetween("header.size_bytes", request.size_bytes, 1, max_size_bytes));
  status.Update(convert::CheckSha256("header.sha256", request.sha256));
  return status;
}

absl::Status CheckStorage(MapStore& store, const UploadRequest& request,
                          std::int64_t max_tenant_bytes) {
  if (max_tenant_bytes == 0) return absl::OkStatus();
  const std::string prefix = ScopedMapName(request.tenant, "");
  // A file that the tenant has already takes no more room.
  const absl::StatusOr<std::int64_t> known = store.catalogue().SizeOfFile(prefix, request.sha256);
  if (!known.ok()) return known.status();
  if (*known != 0) return absl::OkStatus();
  const absl::StatusOr<std::int64_t> used = store.catalogue().SizeOfMaps(prefix);
  if (!used.ok()) return used.status();
  const absl::StatusOr<std::int64_t> unfinished =
      store.incoming().SizeOfOthers(request.tenant, request.sha256);
  if (!unfinished.ok()) return unfinished.status();
  if (*used + *unfinished + request.size_bytes <= max_tenant_bytes) return absl::OkStatus();
  return absl::ResourceExhaustedError(
      absl::StrFormat("the maps take %d bytes, unfinished uploads %d, and header.size_bytes is %d; "
                      "max_tenant_storage_mib is %d",
                      *used, *unfinished, request.size_bytes, max_tenant_bytes >> 20));
}

absl::StatusOr<std::shared_ptr<const RadarMap>> VerifyMap(const std::filesystem::path& path) {
  absl::StatusOr<std::shared_ptr<const RadarMap>> map = RadarMap::Open(path);
  absl::Status status = map.status();
  if (status.ok()) status = (*map)->Verify();
  if (status.ok()) return map;
  // Paths of this machine are nothing to a client.
  return absl::DataLossError(
      absl::StrCat("the file is no intact map: ",
                   absl::StripPrefix(status.message(), absl::StrCat(path.string(), ": "))));
}

}  // namespace

Upload::Upload(MapStore& store, UploadRequest request, IncomingFile file)
    : store_(&store), request_(std::move(request)), file_(std::move(file)) {}

absl::StatusOr<Upload> Upload::Begin(MapStore& store, UploadRequest request,
                                     const UploadLimits& limits) {
  absl::Status status = Validate(request, limits.max_map_bytes);
  if (status.ok()) status = CheckStorage(store, request, limits.max_tenant_bytes);
  if (!status.ok()) return status;
  IncomingFile file = store.incoming().Take(request.tenant, request.sha256);
  return Upload(store, std::move(request), std::move(file));
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
  if (!sha256.ok()) return sha256.status();
  if (*sha256 != request_.sha256) {
    file_.Remove().IgnoreError();
    return absl::DataLossError(absl::StrFormat(
        "the bytes that came have the hash %s; header.sha256 is %s", *sha256, request_.sha256));
  }
  absl::StatusOr<std::shared_ptr<const RadarMap>> map = VerifyMap(file_.path());
  if (!map.ok()) {
    file_.Remove().IgnoreError();
    return map.status();
  }
  return store_->Add(file_.path(), map_name, *sha256, *std::move(map));
}

}  // namespace dcloc::server
