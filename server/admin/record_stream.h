#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>

#include "dcloc/v1/admin_service.pb.h"
#include "server/admin/push_stream.h"
#include "server/admin/record_election.h"
#include "server/sessions/recording_subscriber.h"

namespace dcloc::server {

/// Counts the running recordings. A slot is given back when its holder is destroyed.
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
class RecordStream final : public PushStream<v1::RecordSessionResponse>,
                           public RecordingSubscriber {
 public:
  /// Bound on the messages that wait to be written.
  static constexpr std::size_t kMaxWaiting_bytes = 32 << 20;

  /// `program` is named in the recording.
  static std::shared_ptr<RecordStream> Start(const RpcContext& host,
                                             grpc::CallbackServerContext* context,
                                             std::string program);

  /// To be called before it waits for a session: the caller can keep position fixes. Without it the
  /// first one ends the call.
  void IncludeFixes() { takes_fixes_ = true; }

  /// To be called before it waits for a session: it may also be recorded at other replicas.
  void Join(std::shared_ptr<RecordElection> election) { election_ = std::move(election); }

  /// What the replica of `place` in the election says.
  void OnRelayed(int place, v1::RecordSessionResponse message);
  void OnRelayEnd(int place, const std::string& address, const grpc::Status& status);

  /// Whether the session that is recorded is somewhere, and elsewhere than at `place`.
  bool IsDecidedAgainst(int place) const;

  /// This server stops: without a session of its own there is nothing more to record.
  void EndAtStop();

  /// Says whether the caller may record; then it holds `slot`, else the call ends. Nothing is
  /// written before.
  void Begin(const absl::Status& status, std::shared_ptr<void> slot);

  bool TakesFixes() const override { return takes_fixes_; }
  void OnOpened(const RecordingStart& start) override;
  void OnScan(const v1::Scan& scan, const ScanAnswer& answer) override;
  void OnFix(const v1::PositionFix& fix, const FixAnswer& answer) override;
  void OnEnd(const absl::Status& status) override;

 private:
  RecordStream(const RpcContext& host, grpc::CallbackServerContext* context, std::string program)
      : PushStream(host, context), program_(std::move(program)) {}

  /// Whether the session of this server is the one that is recorded.
  bool IsHere() const { return election_ == nullptr || election_->Take(RecordElection::kHere); }

  template <typename Fill>
  void FillAndPush(Fill fill);
  void Push(v1::RecordSessionResponse message);
  void OnWrite(v1::RecordSessionResponse& message) override;
  void OnFinish() override { slot_.reset(); }

  const std::string program_;
  bool takes_fixes_ = false;
  std::shared_ptr<RecordElection> election_;  ///< null where it can only be here
  std::shared_ptr<void> slot_;
  bool has_begun_here_ = false;
  std::size_t waiting_bytes_ = 0;
};

}  // namespace dcloc::server
