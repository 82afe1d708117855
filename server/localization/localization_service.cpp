#include "server/localization/localization_service.h"

#include <utility>

#include "absl/strings/str_format.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {

LocalizationService::LocalizationService(SessionHost host) : host_(std::move(host)) {}

grpc::ServerBidiReactor<v1::LocalizeRequest, v1::LocalizeResponse>* LocalizationService::Localize(
    grpc::CallbackServerContext* context) {
  const std::shared_ptr<LocalizeStream> stream =
      LocalizeStream::Start(host_, context, [this](LocalizeStream* done) { Forget(done); });
  const int max_stream_count = host_.storage.limits.max_session_count;
  grpc::Status refusal;
  {
    const std::lock_guard lock(mutex_);
    streams_.emplace(stream.get(), OpenStream{stream, OpenCalls::Token(host_.storage.open_calls)});
    refusal = refusal_;
    if (refusal.ok() && static_cast<int>(streams_.size()) > max_stream_count) {
      refusal = grpc::Status(
          grpc::StatusCode::RESOURCE_EXHAUSTED,
          absl::StrFormat("%d sessions are open, which is the limit", max_stream_count));
    }
  }
  if (!refusal.ok()) stream->End(refusal);
  return stream.get();
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
  return !refusal_.ok();
}

bool LocalizationService::EndOverdue(Clock::time_point now) {
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

void LocalizationService::Forget(LocalizeStream* stream) {
  const std::lock_guard lock(mutex_);
  streams_.erase(stream);
}

}  // namespace dcloc::server
