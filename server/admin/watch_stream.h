#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "dcloc/v1/admin_service.pb.h"
#include "server/admin/push_stream.h"
#include "server/sessions/answer_feed.h"

namespace dcloc::server {

/// One WatchSession call: a session's answers to someone who watches. A slow watcher misses
/// answers; the session never waits.
class WatchStream final : public PushStream<v1::WatchSessionResponse>, public AnswerSubscriber {
 public:
  static std::shared_ptr<WatchStream> Start(const RpcContext& host,
                                            grpc::CallbackServerContext* context);

  /// Says whether the session was found. If not, the call ends. Nothing is written before.
  void Begin(const absl::Status& status) { BeginWith(status); }

  /// To be called before it is subscribed: it also gets the answers to position fixes.
  void IncludeFixAnswers() { takes_fix_answers_ = true; }

  /// To be called before it is subscribed: it also gets the scans, and once the session's rig.
  void IncludeScans(const v1::Rig& rig) { rig_ = rig; }

  void OnAnswer(const ScanAnswer& answer, const v1::Scan* scan) override;
  void OnFixAnswer(const FixAnswer& answer) override;
  void OnEnd() override { End(grpc::Status::OK); }

  /// What another server's stream of the session says.
  void OnRelayed(v1::WatchSessionResponse message);
  void OnRelayEnd(const grpc::Status& status) { End(status); }

  /// This server stops while another one's session goes on.
  void EndAtStop() { End(Stopping()); }

 private:
  using PushStream::PushStream;

  template <typename Fill>
  bool FillAndQueue(Fill fill);
  void Queue(v1::WatchSessionResponse message);
  void DropOldest();
  void OnWrite(v1::WatchSessionResponse& message) override;

  bool takes_fix_answers_ = false;
  std::optional<v1::Rig> rig_;  ///< of a session whose scans are wanted
  bool rig_is_queued_ = false;
  std::int64_t missed_count_ = 0;
  std::size_t waiting_bytes_ = 0;
};

}  // namespace dcloc::server
