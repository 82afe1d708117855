#include "server/localization/localization_service.h"

#include <algorithm>
#include <new>
#include <string>
#include <utility>

#include "server/rpc/refused_stream.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {

LocalizationService::LocalizationService(StreamContext host) : host_(std::move(host)) {}

grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* LocalizationService::Localize(
    grpc::CallbackServerContext* context) {
  return BeginWithinMemory<grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>>(
      [&] { return Begin(context); });
}

LocalizeStream* LocalizationService::Begin(grpc::CallbackServerContext* context) {
  const std::shared_ptr<LocalizeStream> stream = LocalizeStream::Create(host_, context, *this);
  grpc::Status draining;
  std::optional<Refusal> excess;
  try {
    const std::lock_guard lock(mutex_);
    streams_.emplace(stream.get(), OpenStream{stream, OpenCalls::Token(host_.storage.open_calls)});
    excess = RefusalOf(unopened_.Add(stream.get(), AddressOf(context->peer()), Bounds()));
    draining = refusal_;
  } catch (const std::bad_alloc&) {
    OnDone(*stream);
    throw;
  }
  if (excess) excess->stream->End(std::move(excess->status));
  if (!draining.ok()) stream->End(std::move(draining));
  stream->Admit();
  return stream.get();
}

int LocalizationService::GiveNotice(Clock::time_point end, std::chrono::milliseconds grace) {
  std::vector<std::shared_ptr<LocalizeStream>> open;
  {
    const std::lock_guard lock(mutex_);
    if (notice_ || !refusal_.ok()) return 0;
    notice_ = {.end = end, .grace = grace};
    open = Streams();
  }
  spdlog::info("not ready any more, sessions are told to move later streams={}", open.size());
  return static_cast<int>(
      std::ranges::count_if(open, [](const auto& stream) { return stream->resumable(); }));
}

int LocalizationService::Drain(std::chrono::milliseconds grace) {
  v1::SessionEnding ending;
  ending.set_reason(v1::SESSION_END_REASON_DRAINING);
  ending.set_message("the server takes no more sessions and will stop");
  ending.set_grace_duration_ns(std::chrono::nanoseconds(grace).count());
  std::vector<std::shared_ptr<LocalizeStream>> open;
  {
    const std::lock_guard lock(mutex_);
    if (!refusal_.ok()) return 0;
    notice_.reset();
    refusal_ = grpc::Status(grpc::StatusCode::UNAVAILABLE, "the server is draining");
    drain_end_ = Clock::now() + grace;
    open = Streams();
  }
  int told = 0;
  for (const auto& stream : open) {
    stream->Announce(ending);
    told += stream->resumable() ? 1 : 0;
  }
  spdlog::info("draining streams={} told={} grace_ms={}", open.size(), told, grace.count());
  return told;
}

bool LocalizationService::draining() const {
  const std::lock_guard lock(mutex_);
  return notice_ || !refusal_.ok();
}

bool LocalizationService::EndOverdue(Clock::time_point now) {
  std::optional<Notice> over;
  {
    const std::lock_guard lock(mutex_);
    if (notice_ && now >= notice_->end) over = notice_;
  }
  if (over) Drain(over->grace);
  {
    const std::lock_guard lock(mutex_);
    if (refusal_.ok()) return false;
    if (!drain_end_) return true;
    if (now < *drain_end_) return false;
    drain_end_.reset();
  }
  EndAll(grpc::Status(grpc::StatusCode::UNAVAILABLE, "the server is draining"));
  return true;
}

void LocalizationService::EndAll(const grpc::Status& status) {
  std::vector<std::shared_ptr<LocalizeStream>> open;
  {
    const std::lock_guard lock(mutex_);
    refusal_ = status;
    open = Streams();
  }
  for (const auto& stream : open) stream->End(status);
}

std::vector<std::shared_ptr<LocalizeStream>> LocalizationService::Streams() {
  std::vector<std::shared_ptr<LocalizeStream>> open;
  for (const auto& [address, entry] : streams_) {
    if (auto held = entry.stream.lock()) open.push_back(std::move(held));
  }
  return open;
}

int LocalizationService::unopened_count() const {
  const std::lock_guard lock(mutex_);
  return unopened_.count();
}

WaitingBounds LocalizationService::Bounds() const {
  const Limits& limits = host_.storage.limits;
  return {.total = limits.max_unopened_stream_count,
          .group = limits.max_unopened_stream_count_per_peer};
}

std::optional<LocalizationService::Refusal> LocalizationService::RefusalOf(
    const std::optional<Unopened::Excess>& excess) {
  if (!excess) return std::nullopt;
  std::shared_ptr<LocalizeStream> stream = streams_.at(excess->call).stream.lock();
  if (stream == nullptr) return std::nullopt;
  ++host_.storage.peer_bound_calls.faults().too_many_waiting;
  return Refusal{std::move(stream),
                 grpc::Status(grpc::StatusCode::RESOURCE_EXHAUSTED, excess->reason)};
}

void LocalizationService::OnAdmitted(LocalizeStream& stream, const Principal& principal) {
  // As long as there are no identities, all are the same one; their addresses tell more.
  if (host_.storage.access.IsOpen().value_or(true)) return;
  std::optional<Refusal> excess;
  {
    const std::lock_guard lock(mutex_);
    excess = RefusalOf(
        unopened_.Move(&stream, ScopedMapName(principal.tenant, principal.name), Bounds()));
  }
  if (excess) excess->stream->End(std::move(excess->status));
}

void LocalizationService::OnFirstMessage(LocalizeStream& stream) {
  const std::lock_guard lock(mutex_);
  unopened_.Remove(&stream);
}

void LocalizationService::OnDone(LocalizeStream& stream) {
  const std::lock_guard lock(mutex_);
  unopened_.Remove(&stream);
  streams_.erase(&stream);
}

}  // namespace dcloc::server
