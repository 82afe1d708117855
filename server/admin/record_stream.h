#pragma once

#include <grpcpp/support/server_callback.h>

#include <atomic>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "dcloc/v1/admin_service.pb.h"
#include "server/base/open_calls.h"
#include "server/sessions/recording_subscriber.h"

namespace dcloc::server {

/// How many recordings there are. A reservation ends with its holder.
class RecordingSlots {
 public:
  /// Null when all are taken.
  std::shared_ptr<void> Take(int max);

 private:
  std::shared_ptr<std::atomic<int>> taken_ = std::make_shared<std::atomic<int>>(0);
};

/// One RecordSession call: a session's scans and answers, from its opening to its end. Nothing is
/// left out: when the caller is too slow for the session, the call ends with RESOURCE_EXHAUSTED;
/// the session never waits.
class RecordStream final : public grpc::ServerWriteReactor<v1::RecordSessionResponse>,
                           public RecordingSubscriber,
                           public std::enable_shared_from_this<RecordStream> {
 public:
  /// What may wait to be written.
  static constexpr std::size_t kMaxWaiting_bytes = 32 << 20;

  /// Lives until the call is done and the session has let go of it. `program` is named in the
  /// recording.
  static std::shared_ptr<RecordStream> Start(OpenCalls& open_calls, std::string program);

  /// The caller may record, and holds `slot`; or not, which ends the call. Nothing is written
  /// before.
  void Begin(const absl::Status& status, std::shared_ptr<void> slot);

  void OnOpened(const RecordingStart& start) override;
  void OnScan(const v1::Scan& scan, const ScanAnswer& answer) override;
  void OnEnd() override { End(grpc::Status::OK); }

  void OnWriteDone(bool ok) override;
  void OnCancel() override { End(grpc::Status(grpc::StatusCode::CANCELLED, "cancelled")); }
  void OnDone() override;

 private:
  RecordStream(OpenCalls& open_calls, std::string program)
      : token_(open_calls), program_(std::move(program)) {}

  /// Ends the call; once what waits is written if all is well, else at once.
  void End(const grpc::Status& status);
  void Push(v1::RecordSessionResponse message);
  void Pump();  // with the mutex held

  std::shared_ptr<RecordStream> self_;  ///< reset by OnDone
  const OpenCalls::Token token_;
  const std::string program_;
  std::mutex mutex_;
  std::shared_ptr<void> slot_;
  std::deque<v1::RecordSessionResponse> waiting_;
  std::size_t waiting_bytes_ = 0;
  v1::RecordSessionResponse message_;  ///< the transport's while writing_
  bool begun_ = false;
  bool writing_ = false;
  bool finished_ = false;
  std::optional<grpc::Status> end_status_;
};

}  // namespace dcloc::server
