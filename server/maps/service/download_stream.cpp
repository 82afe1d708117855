#include "server/maps/service/download_stream.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/base/check.h"
#include "server/base/status.h"
#include "server/base/waiting_calls.h"
#include "server/base/within_memory.h"
#include "server/convert/map.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

constexpr std::size_t kChunk_bytes = std::size_t{1} << 20;

/// Whose share of the downloads one counts to: a principal's, or an address' where nobody has one.
std::string CallerOf(const Principal& principal, const grpc::CallbackServerContext& context) {
  if (!principal.name.empty()) return absl::StrCat(principal.tenant, "/", principal.name);
  return AddressOf(context.peer());
}

}  // namespace

DownloadStream* DownloadStream::Start(const RpcContext& host, DownloadSlots& slots,
                                      grpc::CallbackServerContext* context,
                                      const v1::DownloadMapRequest& request) {
  std::shared_ptr<DownloadStream> stream(new DownloadStream(host, slots, context));
  host.peer_bound_calls.Add(stream);
  stream->self_ = stream;
  stream->PostOrEnd([stream, &request] { stream->SendVersion(request); });
  return stream.get();
}

DownloadStream::DownloadStream(const RpcContext& host, DownloadSlots& slots,
                               grpc::CallbackServerContext* context)
    : host_(host), slots_(slots), context_(context), token_(host.open_calls), strand_(host.pool) {
  strand_.SetLane(Lane::kLengthy);
}

void DownloadStream::OnWriteDone(bool ok) {
  peer_wait_.End();
  PostOrEnd([self = shared_from_this(), ok] {
    ok ? self->SendChunk() : self->End(absl::CancelledError("cancelled"));
  });
}

/// Nothing may be thrown into gRPC's threads, nor a call wait for a task that is not there.
template <typename Work>
void DownloadStream::PostOrEnd(Work work) {
  const absl::Status posted = WithinMemory([&] { strand_.Post(std::move(work)); });
  if (!posted.ok()) End(posted);
}

void DownloadStream::OnDone() { const std::shared_ptr<DownloadStream> last = std::move(self_); }

void DownloadStream::CheckPeer(PeerWait::Clock::time_point now) {
  if (!peer_wait_.TakeOverdue(now)) return;
  const absl::Status posted =
      WithinMemory([this] { strand_.Post([self = shared_from_this()] { self->CutOff(); }); });
  if (!posted.ok()) context_->TryCancel();
}

/// The write that nobody takes fails then, which ends the call.
void DownloadStream::CutOff() {
  if (ended_) return;
  ++host_.peer_bound_calls.faults().not_reading;
  spdlog::warn("download cut off peer={} reason=\"it is not read\"", context_->peer());
  context_->TryCancel();
}

void DownloadStream::Send() {
  peer_wait_.Begin(std::chrono::milliseconds(host_.limits.peer_timeout_ms));
  StartWrite(&response_);
}

void DownloadStream::SendVersion(const v1::DownloadMapRequest& request) {
  const absl::Status status = FillWithinMemory(&response_, [&]() -> absl::Status {
    absl::Status opened = Open(request);
    if (opened.ok()) convert::ToProto(map_.record, response_.mutable_version());
    return opened;
  });
  status.ok() ? Send() : End(status);
}

absl::Status DownloadStream::Open(const v1::DownloadMapRequest& request) {
  const absl::StatusOr<Principal> principal =
      host_.access.Authorize(*context_, v1::DownloadMapRequest::descriptor());
  if (!principal.ok()) return principal.status();
  absl::Status status = CheckMapName("map_name", request.map_name());
  status.Update(CheckIntegerBetween("version", request.version(), 0,
                                    std::numeric_limits<std::int64_t>::max()));
  if (!status.ok()) return status;
  absl::StatusOr<std::shared_ptr<void>> slot = slots_.Take(
      CallerOf(*principal, *context_), {.total = host_.limits.max_download_count,
                                        .caller = host_.limits.max_download_count_per_caller});
  if (!slot.ok()) return slot.status();
  slot_ = *std::move(slot);
  absl::StatusOr<LoadedMap> map =
      host_.store.Acquire(ScopedMapName(principal->tenant, request.map_name()), request.version());
  if (!map.ok()) return map.status();
  map_ = *std::move(map);
  return absl::OkStatus();
}

void DownloadStream::SendChunk() {
  const std::span<const std::byte> left = map_.map->bytes().subspan(sent_bytes_);
  if (left.empty()) return End(absl::OkStatus());
  const std::size_t size = std::min(kChunk_bytes, left.size());
  const absl::Status filled = FillWithinMemory(&response_, [&] {
    v1::MapChunk* chunk = response_.mutable_chunk();
    chunk->set_offset_bytes(static_cast<std::int64_t>(sent_bytes_));
    chunk->set_data(left.data(), size);
  });
  sent_bytes_ += size;
  filled.ok() ? Send() : End(filled);
}

void DownloadStream::End(const absl::Status& status) {
  // Before the client hears of the end, who may then delete the version.
  if (ended_.exchange(true)) return;
  map_ = {};
  slot_.reset();
  Finish(ToGrpc(status));
}

}  // namespace dcloc::server
