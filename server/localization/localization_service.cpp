#include "server/localization/localization_service.h"

#include <vector>

#include "absl/strings/str_format.h"

namespace dcloc::server {

LocalizationService::LocalizationService(SessionHost host, int max_session_count)
    : host_(host), max_session_count_(max_session_count) {}

grpc::ServerBidiReactor<v1::LocalizeRequest, v1::LocalizeResponse>* LocalizationService::Localize(
    grpc::CallbackServerContext* context) {
  const std::shared_ptr<LocalizeStream> stream =
      LocalizeStream::Start(host_, context->peer(), [this](LocalizeStream* done) { Forget(done); });
  grpc::Status refusal;
  {
    const std::lock_guard lock(mutex_);
    streams_.emplace(stream.get(), OpenStream{stream, OpenCalls::Token(host_.storage.open_calls)});
    refusal = refusal_;
    if (refusal.ok() && static_cast<int>(streams_.size()) > max_session_count_) {
      refusal = grpc::Status(
          grpc::StatusCode::RESOURCE_EXHAUSTED,
          absl::StrFormat("%d sessions are open, which is the limit", max_session_count_));
    }
  }
  if (!refusal.ok()) stream->End(refusal);
  return stream.get();
}

void LocalizationService::EndAll(const grpc::Status& status) {
  std::vector<std::shared_ptr<LocalizeStream>> open;
  {
    const std::lock_guard lock(mutex_);
    refusal_ = status;
    for (const auto& [address, entry] : streams_) {
      if (auto held = entry.stream.lock()) open.push_back(std::move(held));
    }
  }
  for (const auto& stream : open) stream->End(status);
}

void LocalizationService::Forget(LocalizeStream* stream) {
  const std::lock_guard lock(mutex_);
  streams_.erase(stream);
}

}  // namespace dcloc::server
