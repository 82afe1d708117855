#include "server/maps/service/download_stream.h"

#include <algorithm>
#include <limits>
#include <span>
#include <utility>

#include "server/base/check.h"
#include "server/base/status.h"
#include "server/convert/map.h"

namespace dcloc::server {
namespace {

constexpr std::size_t kChunk_bytes = std::size_t{1} << 20;

}  // namespace

DownloadStream* DownloadStream::Start(const StorageHost& host, grpc::CallbackServerContext* context,
                                      const v1::DownloadMapRequest& request) {
  std::shared_ptr<DownloadStream> stream(new DownloadStream(host));
  stream->self_ = stream;
  stream->strand_.Post([stream, context, request] { stream->SendVersion(*context, request); });
  return stream.get();
}

DownloadStream::DownloadStream(const StorageHost& host)
    : host_(host), token_(host.open_calls), strand_(host.pool) {
  strand_.SetLane(Lane::kLengthy);
}

void DownloadStream::OnWriteDone(bool ok) {
  if (ok) {
    strand_.Post([self = shared_from_this()] { self->SendChunk(); });
  } else {
    End(absl::CancelledError("cancelled"));
  }
}

void DownloadStream::OnDone() { const std::shared_ptr<DownloadStream> last = std::move(self_); }

void DownloadStream::SendVersion(const grpc::CallbackServerContext& context,
                                 const v1::DownloadMapRequest& request) {
  const absl::StatusOr<Principal> principal =
      host_.access.Authorize(context, v1::DownloadMapRequest::descriptor());
  if (!principal.ok()) return End(principal.status());
  absl::Status status = CheckMapName("map_name", request.map_name());
  status.Update(CheckIntegerBetween("version", request.version(), 0,
                                    std::numeric_limits<std::int64_t>::max()));
  if (!status.ok()) return End(status);
  absl::StatusOr<LoadedMap> map =
      host_.store.Acquire(ScopedMapName(principal->tenant, request.map_name()), request.version());
  if (!map.ok()) return End(map.status());
  map_ = *std::move(map);
  convert::ToProto(map_.record, response_.mutable_version());
  StartWrite(&response_);
}

void DownloadStream::SendChunk() {
  const std::span<const std::byte> left = map_.map->bytes().subspan(sent_bytes_);
  if (left.empty()) return End(absl::OkStatus());
  const std::size_t size = std::min(kChunk_bytes, left.size());
  v1::MapChunk* chunk = response_.mutable_chunk();
  chunk->set_offset_bytes(static_cast<std::int64_t>(sent_bytes_));
  chunk->set_data(left.data(), size);
  sent_bytes_ += size;
  StartWrite(&response_);
}

void DownloadStream::End(const absl::Status& status) {
  // Before the client hears of the end, who may then delete the version.
  map_ = {};
  Finish(ToGrpc(status));
}

}  // namespace dcloc::server
