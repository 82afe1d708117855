#include "client/sdk/map_download.h"

#include <grpcpp/client_context.h>

#include <cerrno>
#include <fstream>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/sdk/sha256.h"
#include "client/sdk/status.h"

namespace dcloc::client {
namespace {

using Reader = grpc::ClientReader<v1::DownloadMapResponse>;

/// Writes the chunks to `path`. An error of the file's; the call's own status says the rest.
absl::Status WriteChunks(Reader& reader, std::int64_t size_bytes, const std::filesystem::path& path,
                         const TransferProgress& progress) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  if (!file) return absl::ErrnoToStatus(errno, path.string());
  v1::DownloadMapResponse response;
  std::int64_t done_bytes = 0;
  while (reader.Read(&response)) {
    const std::string& data = response.chunk().data();
    if (!file.write(data.data(), static_cast<std::streamsize>(data.size()))) {
      return absl::ErrnoToStatus(errno, path.string());
    }
    done_bytes += static_cast<std::int64_t>(data.size());
    if (progress) progress(done_bytes, size_bytes);
  }
  file.close();
  return file ? absl::OkStatus() : absl::ErrnoToStatus(errno, path.string());
}

absl::Status CheckHash(const std::filesystem::path& path, const std::string& expected) {
  const absl::StatusOr<std::string> sha256 = Sha256OfFile(path);
  if (!sha256.ok()) return sha256.status();
  if (*sha256 == expected) return absl::OkStatus();
  return absl::DataLossError(
      absl::StrCat("the bytes that came have the hash ", *sha256, "; the version's is ", expected));
}

}  // namespace

absl::StatusOr<v1::MapVersion> DownloadMapFile(v1::MapService::Stub& stub,
                                               const v1::DownloadMapRequest& request,
                                               const std::filesystem::path& file,
                                               const TransferProgress& progress) {
  // No deadline: how long it takes depends on the map, and keepalive notices a dead connection.
  grpc::ClientContext context;
  const auto reader = stub.DownloadMap(&context, request);
  v1::DownloadMapResponse first;
  const bool begun = reader->Read(&first);
  if (!begun || !first.has_version()) {
    if (begun) context.TryCancel();
    const absl::Status end = FromGrpc(reader->Finish());
    if (!begun && !end.ok()) return end;
    return absl::DataLossError("the download does not begin with its version");
  }
  v1::MapVersion version = std::move(*first.mutable_version());
  const std::filesystem::path part = file.string() + ".part";
  absl::Status status = WriteChunks(*reader, version.size_bytes(), part, progress);
  if (!status.ok()) context.TryCancel();
  const grpc::Status end = reader->Finish();
  if (status.ok()) status = FromGrpc(end);
  if (status.ok()) status = CheckHash(part, version.sha256());
  std::error_code error;
  if (status.ok()) {
    std::filesystem::rename(part, file, error);
    if (!error) return version;
    status = absl::InternalError(absl::StrCat(file.string(), ": ", error.message()));
  }
  std::filesystem::remove(part, error);
  return status;
}

}  // namespace dcloc::client
