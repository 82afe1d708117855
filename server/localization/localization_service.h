#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "dcloc/v1/localization_service.grpc.pb.h"
#include "server/localization/localize_stream.h"

namespace dcloc::server {

/// Starts a LocalizeStream for each call and keeps track of those that are open.
class LocalizationService final : public v1::LocalizationService::CallbackService {
 public:
  using Clock = std::chrono::steady_clock;

  explicit LocalizationService(SessionHost host);

  grpc::ServerBidiReactor<v1::LocalizeRequest, v1::LocalizeResponse>* Localize(
      grpc::CallbackServerContext* context) override;

  /// Refuses new calls and tells the clients of resumable sessions to move; returns how many those
  /// are. After `grace`, `EndOverdue` ends the remaining calls. Only the first call has an effect.
  int Drain(std::chrono::milliseconds grace);

  bool draining() const;

  /// Ends all calls if the grace of a drain is over at `now`; returns whether it is.
  bool EndOverdue(Clock::time_point now);

  /// Ends all present and future calls, each once the scans that were read are answered.
  void EndAll(const grpc::Status& status);

 private:
  struct OpenStream {
    std::weak_ptr<LocalizeStream> stream;
    OpenCalls::Token token;
  };

  std::vector<std::shared_ptr<LocalizeStream>> Streams();  // with the mutex held
  void Forget(LocalizeStream* stream);

  const SessionHost host_;

  mutable std::mutex mutex_;
  std::map<LocalizeStream*, OpenStream> streams_;
  grpc::Status refusal_;  ///< not OK once new calls are refused
  std::optional<Clock::time_point> drain_end_;
};

}  // namespace dcloc::server
