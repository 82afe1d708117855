#include "server/maps/upload.h"

#include <algorithm>
#include <span>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/strip.h"
#include "server/convert/check.h"
#include "server/identity/principal.h"
#include "server/status.h"

namespace dcloc::server {
namespace {

constexpr std::int64_t kMaxChunk_bytes = 1 << 20;

absl::Status Validate(const UploadRequest& request, std::int64_t max_size_bytes) {
  absl::Status status = convert::CheckMapName("header.map_name", request.map_name);
  status.Update(
      convert::CheckIntegerBetween("header.size_bytes", request.size_bytes, 1, max_size_bytes));
  if (status.ok() && !IsSha256(request.sha256)) {
    return absl::InvalidArgumentError(
        absl::StrCat("header.sha256 is ", Quoted(request.sha256),
                     "; it must be 64 lower-case hexadecimal digits"));
  }
  return status;
}

absl::Status CheckStorage(MapStore& store, const UploadRequest& request,
                          std::int64_t max_tenant_bytes) {
  if (max_tenant_bytes == 0) return absl::OkStatus();
  const absl::StatusOr<std::int64_t> used =
      store.catalogue().SizeOfMaps(ScopedMapName(request.tenant, ""));
  if (!used.ok()) return used.status();
  if (*used + request.size_bytes <= max_tenant_bytes) return absl::OkStatus();
  return absl::ResourceExhaustedError(absl::StrFormat(
      "the maps take %d bytes and header.size_bytes is %d; max_tenant_storage_mib is %d", *used,
      request.size_bytes, max_tenant_bytes >> 20));
}

absl::StatusOr<MapInfo> VerifyMap(const std::filesystem::path& path) {
  const absl::StatusOr<std::shared_ptr<const RadarMap>> map = RadarMap::Open(path);
  absl::Status status = map.status();
  status.Update(status.ok() ? (*map)->Verify() : status);
  if (status.ok()) return (*map)->info();
  // Paths of this machine are nothing to a client.
  return absl::DataLossError(
      absl::StrCat("the file is no intact map: ",
                   absl::StripPrefix(status.message(), absl::StrCat(path.string(), ": "))));
}

}  // namespace

Upload::Upload(MapStore& store, UploadRequest request, TemporaryFile file)
    : store_(&store), request_(std::move(request)), file_(std::move(file)) {}

Upload::Upload(Upload&& other) noexcept
    : store_(other.store_),
      request_(std::move(other.request_)),
      file_{std::move(other.file_.descriptor), std::exchange(other.file_.path, {})},
      received_bytes_(other.received_bytes_),
      hash_(std::move(other.hash_)) {}

Upload::~Upload() {
  std::error_code error;
  if (!file_.path.empty()) std::filesystem::remove(file_.path, error);
}

absl::StatusOr<Upload> Upload::Begin(MapStore& store, UploadRequest request,
                                     const UploadLimits& limits) {
  absl::Status status = Validate(request, limits.max_map_bytes);
  status.Update(status.ok() ? CheckStorage(store, request, limits.max_tenant_bytes) : status);
  if (!status.ok()) return status;
  absl::StatusOr<TemporaryFile> file = CreateTemporaryFile(store.incoming_folder(), "upload-");
  if (!file.ok()) return file.status();
  return Upload(store, std::move(request), *std::move(file));
}

absl::Status Upload::Append(std::int64_t offset_bytes, absl::string_view bytes) {
  if (offset_bytes != received_bytes_) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "chunk.offset_bytes is %d; the bytes before it end at %d", offset_bytes, received_bytes_));
  }
  const auto size = static_cast<std::int64_t>(bytes.size());
  absl::Status status = convert::CheckIntegerBetween(
      "the size of chunk.data", size, 0,
      std::min(kMaxChunk_bytes, request_.size_bytes - received_bytes_));
  if (!status.ok()) return status;
  const std::span<const std::byte> data = std::as_bytes(std::span(bytes));
  hash_.Update(data);
  received_bytes_ += size;
  return WriteAll(file_.descriptor, data);
}

absl::StatusOr<MapVersionRecord> Upload::Finish() {
  if (received_bytes_ != request_.size_bytes) {
    return absl::DataLossError(absl::StrFormat("%d bytes came; header.size_bytes is %d",
                                               received_bytes_, request_.size_bytes));
  }
  const std::string sha256 = hash_.Finish();
  if (sha256 != request_.sha256) {
    return absl::DataLossError(absl::StrFormat(
        "the bytes that came have the hash %s; header.sha256 is %s", sha256, request_.sha256));
  }
  if (absl::Status status = Sync(file_.descriptor); !status.ok()) return status;
  const absl::StatusOr<MapInfo> info = VerifyMap(file_.path);
  if (!info.ok()) return info.status();
  return store_->Add(file_.path, ScopedMapName(request_.tenant, request_.map_name), sha256, *info,
                     request_.activate);
}

}  // namespace dcloc::server
