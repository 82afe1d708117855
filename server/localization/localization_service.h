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

  /// Refuses calls from now on and tells the clients of resumable sessions to move; gives how many
  /// those are. After `grace` the rest is to be ended by `EndOverdue`. Only the first call counts.
  int Drain(std::chrono::milliseconds grace);

  bool draining() const;

  /// Ends all calls if a drain's grace is over at `now`; gives whether it is.
  bool EndOverdue(Clock::time_point now);

  /// Ends all calls, those to come as well, once what was read of them is answered.
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
  grpc::Status refusal_;  ///< not OK once there are to be no more
  std::optional<Clock::time_point> drain_end_;
};

}  // namespace dcloc::server
