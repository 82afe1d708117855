#include "client/sdk/map_upload.h"

#include <grpcpp/client_context.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <memory>
#include <thread>
#include <utility>

#include "client/sdk/backoff.h"
#include "client/sdk/sha256.h"
#include "client/sdk/status.h"

namespace dcloc::client {
namespace {

constexpr std::int64_t kChunk_bytes = 256 << 10;
constexpr std::int64_t kSlowestUpload_bytesps = 1'000'000;
constexpr std::chrono::milliseconds kFirstWait(100);
constexpr std::chrono::milliseconds kLongestWait(5000);

using Clock = std::chrono::steady_clock;

/// The server was there and may be again. It ends calls with CANCELLED when it stops.
bool IsBroken(const absl::Status& status) {
  return absl::IsUnavailable(status) || absl::IsCancelled(status);
}

/// The upload of one file, over as many calls as it takes.
class Uploader {
 public:
  Uploader(v1::MapService::Stub& stub, std::ifstream file, v1::UploadMapHeader header,
           const UploadOptions& options, std::chrono::milliseconds timeout)
      : stub_(stub),
        file_(std::move(file)),
        header_(std::move(header)),
        options_(options),
        timeout_(timeout) {}

  absl::StatusOr<v1::MapVersion> Run() {
    Backoff backoff(kFirstWait, kLongestWait);
    absl::StatusOr<v1::MapVersion> version = Attempt();
    while (!version.ok() && MayGoOn(version.status())) {
      std::this_thread::sleep_for(backoff.Next());
      version = Attempt();
      if (progressed_) backoff.Reset();
    }
    return version;
  }

 private:
  bool MayGoOn(const absl::Status& status) {
    // What the server had of the file was not of it; it has been removed.
    if (absl::IsDataLoss(status) && begin_ > 0 && !begun_anew_) return begun_anew_ = true;
    return reached_ && IsBroken(status) && Clock::now() - last_progress_ < options_.give_up_after;
  }

  absl::StatusOr<v1::MapVersion> Attempt() {
    progressed_ = false;
    v1::GetMapUploadRequest request;
    request.set_sha256(header_.sha256());
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + timeout_);
    v1::GetMapUploadResponse there;
    const grpc::Status status = stub_.GetMapUpload(&context, request, &there);
    if (!status.ok()) return FromGrpc(status);
    progressed_ = !reached_ || there.durable_size_bytes() > begin_;
    if (progressed_) last_progress_ = Clock::now();
    reached_ = true;
    begin_ = std::min(there.durable_size_bytes(), header_.size_bytes());
    return SendFrom(there.stored() ? header_.size_bytes() : begin_);
  }

  absl::StatusOr<v1::MapVersion> SendFrom(std::int64_t offset) {
    grpc::ClientContext context;
    context.set_deadline(
        std::chrono::system_clock::now() + timeout_ +
        std::chrono::milliseconds(header_.size_bytes() * 1000 / kSlowestUpload_bytesps));
    v1::UploadMapResponse response;
    const auto writer = stub_.UploadMap(&context, &response);
    v1::UploadMapRequest request;
    *request.mutable_header() = header_;
    if (writer->Write(request)) SendChunks(offset, *writer);
    const grpc::Status status = writer->Finish();
    if (!status.ok()) return FromGrpc(status);
    return std::move(*response.mutable_version());
  }

  /// Until the end, or until the server does not want more; the call's status then says why.
  void SendChunks(std::int64_t offset, grpc::ClientWriter<v1::UploadMapRequest>& writer) {
    file_.clear();
    file_.seekg(offset);
    v1::UploadMapRequest request;
    std::string& data = *request.mutable_chunk()->mutable_data();
    while (offset < header_.size_bytes()) {
      data.resize(static_cast<std::size_t>(std::min(kChunk_bytes, header_.size_bytes() - offset)));
      file_.read(data.data(), static_cast<std::streamsize>(data.size()));
      // A file cut short meanwhile: what arrives no longer fits the hash, and the server says so.
      if (file_.gcount() == 0) break;
      data.resize(static_cast<std::size_t>(file_.gcount()));
      request.mutable_chunk()->set_offset_bytes(offset);
      if (!writer.Write(request)) return;
      offset += file_.gcount();
      if (options_.progress) options_.progress(offset, header_.size_bytes());
    }
    writer.WritesDone();
  }

  v1::MapService::Stub& stub_;
  std::ifstream file_;
  const v1::UploadMapHeader header_;
  const UploadOptions& options_;
  const std::chrono::milliseconds timeout_;
  std::int64_t begin_ = 0;  ///< of the last call's chunks
  bool reached_ = false;
  bool progressed_ = false;
  bool begun_anew_ = false;
  Clock::time_point last_progress_;
};

}  // namespace

absl::StatusOr<v1::MapVersion> UploadMapFile(v1::MapService::Stub& stub,
                                             const std::filesystem::path& file,
                                             const std::string& map_name,
                                             const UploadOptions& options,
                                             std::chrono::milliseconds timeout) {
  const absl::StatusOr<std::string> sha256 = Sha256OfFile(file);
  if (!sha256.ok()) return sha256.status();
  std::ifstream stream(file, std::ios::binary | std::ios::ate);
  if (!stream) return absl::ErrnoToStatus(errno, file.string());
  v1::UploadMapHeader header;
  header.set_map_name(map_name);
  header.set_size_bytes(stream.tellg());
  header.set_sha256(*sha256);
  header.set_activate(options.activate);
  return Uploader(stub, std::move(stream), std::move(header), options, timeout).Run();
}

}  // namespace dcloc::client
