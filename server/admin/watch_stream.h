#pragma once

#include <grpcpp/support/server_callback.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>

#include "absl/status/status.h"
#include "dcloc/v1/admin_service.pb.h"
#include "server/base/open_calls.h"
#include "server/sessions/answer_feed.h"

namespace dcloc::server {

/// One WatchSession call: a session's answers to someone who watches. Who is slow misses answers;
/// the session never waits.
class WatchStream final : public grpc::ServerWriteReactor<v1::WatchSessionResponse>,
                          public AnswerSubscriber,
                          public std::enable_shared_from_this<WatchStream> {
 public:
  /// Lives until the call is done and the session has let go of it.
  static std::shared_ptr<WatchStream> Start(OpenCalls& open_calls);

  /// The session has been found and answers may be written; or not, which ends the call. Nothing is
  /// written before.
  void Begin(const absl::Status& status);

  void OnAnswer(const ScanAnswer& answer) override;
  void OnEnd() override { End(grpc::Status::OK); }

  void OnWriteDone(bool ok) override;
  void OnCancel() override { End(grpc::Status(grpc::StatusCode::CANCELLED, "cancelled")); }
  void OnDone() override;

 private:
  /// Ends the call once what waits is written.
  void End(const grpc::Status& status);

  explicit WatchStream(OpenCalls& open_calls) : token_(open_calls) {}

  void Pump();  // with the mutex held

  std::shared_ptr<WatchStream> self_;  ///< reset by OnDone
  const OpenCalls::Token token_;
  std::mutex mutex_;
  std::deque<v1::WatchSessionResponse> waiting_;
  v1::WatchSessionResponse response_;  ///< the transport's while writing_
  std::int64_t missed_count_ = 0;
  bool begun_ = false;
  bool writing_ = false;
  bool finished_ = false;
  std::optional<grpc::Status> end_status_;
};

}  // namespace dcloc::server
