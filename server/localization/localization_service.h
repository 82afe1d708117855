#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "dcloc/v1/localization_service.grpc.pb.h"
#include "server/base/waiting_calls.h"
#include "server/localization/localize_stream.h"

namespace dcloc::server {

/// Messages come and go as bytes, see `ParseMessage`.
using RawLocalizationService =
    v1::LocalizationService::WithRawCallbackMethod_Localize<v1::LocalizationService::Service>;

/// Starts a LocalizeStream for each call and keeps track of those that are open.
class LocalizationService final : public RawLocalizationService, private StreamKeeper {
 public:
  using Clock = std::chrono::steady_clock;

  explicit LocalizationService(StreamContext host);

  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* Localize(
      grpc::CallbackServerContext* context) override;

  /// For those who ask it is draining, so that a router looks for another server; new calls are
  /// still taken until `end`, when `EndOverdue` does as `Drain` does. Returns how many resumable
  /// sessions there are. Without effect once it is draining.
  int GiveNotice(Clock::time_point end, std::chrono::milliseconds grace);

  /// Refuses new calls and tells the clients of resumable sessions to move; returns how many those
  /// are. After `grace`, `EndOverdue` ends the remaining calls. Only the first call has an effect,
  /// and ends the notice.
  int Drain(std::chrono::milliseconds grace);

  /// Since `GiveNotice` or `Drain`.
  bool draining() const;

  /// Streams whose first message has not come.
  int unopened_count() const;

  /// Goes on with a drain whose notice is over at `now`, and ends all calls once its grace is;
  /// returns whether that is so.
  bool EndOverdue(Clock::time_point now);

  /// Ends all present and future calls, each once the scans that were read are answered.
  void EndAll(const grpc::Status& status);

 private:
  using Unopened = WaitingCalls<LocalizeStream>;

  struct OpenStream {
    std::weak_ptr<LocalizeStream> stream;
    OpenCalls::Token token;
  };

  /// Without memory nothing is left of the call.
  LocalizeStream* Begin(grpc::CallbackServerContext* context);

  /// A stream that has to go, and how.
  struct Refusal {
    std::shared_ptr<LocalizeStream> stream;
    grpc::Status status;
  };

  /// A drain of which the vehicles are not told yet.
  struct Notice {
    Clock::time_point end;
    std::chrono::milliseconds grace;
  };

  // With the mutex held.
  std::vector<std::shared_ptr<LocalizeStream>> Streams();
  WaitingBounds Bounds() const;
  std::optional<Refusal> RefusalOf(const std::optional<Unopened::Excess>& excess);

  void OnAdmitted(LocalizeStream& stream, const Principal& principal) override;
  void OnFirstMessage(LocalizeStream& stream) override;
  void OnDone(LocalizeStream& stream) override;

  const StreamContext host_;

  mutable std::mutex mutex_;
  std::map<LocalizeStream*, OpenStream> streams_;
  Unopened unopened_;
  grpc::Status refusal_;  ///< not OK once new calls are refused
  std::optional<Notice> notice_;
  std::optional<Clock::time_point> drain_end_;
};

}  // namespace dcloc::server
