#pragma once

#include <grpcpp/support/server_callback.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "dcloc/v1/localization_service.pb.h"
#include "server/base/worker_pool.h"
#include "server/rpc/storage_host.h"
#include "server/sessions/session.h"
#include "server/sessions/session_registry.h"
#include "server/sessions/session_stream.h"

namespace dcloc::server {

/// What all streams share; outlives them.
struct SessionHost {
  const StorageHost& storage;  ///< opening a session may wait for a disk
  SessionRegistry& registry;
  SessionContext sessions;
  UsageCounts& usages;
  int max_pending_scan_count;  ///< per session
};

/// One Localize call: the stream that a session is attached to, or shall be.
///
/// Its requests go through a ring of slots: read, answered on the session's strand, written, free
/// again. A slot's request and response are used over and over, each request gets exactly one
/// response, and the next read starts only when a slot is free, so that neither a fast writer nor a
/// slow reader can make the server's memory grow. Where the client asked for the oldest scans to be
/// dropped the ring is longer, and a scan too many is marked and answered in its turn.
///
/// The transport's events, the pool's and a shutdown change the state under the mutex, and then
/// `Pump` starts what the state allows. Only one thread at a time is in it, and it holds no lock
/// while it calls gRPC: there is one write at a time, and nothing can follow `Finish`.
class LocalizeStream final
    : public grpc::ServerBidiReactor<v1::LocalizeRequest, v1::LocalizeResponse>,
      public SessionStream,
      public std::enable_shared_from_this<LocalizeStream> {
 public:
  /// Lives until the call is done and the pools have let go of it. `on_done` is called once, when
  /// the transport has no more use for it. `context` outlives the call.
  static std::shared_ptr<LocalizeStream> Start(const SessionHost& host,
                                               grpc::CallbackServerContext* context,
                                               std::function<void(LocalizeStream*)> on_done);

  void Announce(const v1::SessionEnding& ending) override;
  void End(grpc::Status status) override;
  void Displace(grpc::Status status) override;
  void Abort() override;

  /// Whether its client asked for a session that it can resume.
  bool resumable() const;

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

 private:
  struct Slot {
    v1::LocalizeRequest request;
    v1::LocalizeResponse response;
    Arrival arrival;
    bool dropped = false;
  };
  enum class Step { kNone, kRead, kWrite, kAnnounce, kFinish };

  LocalizeStream(const SessionHost& host, grpc::CallbackServerContext* context,
                 std::function<void(LocalizeStream*)> on_done);

  void Pump();
  Step TakeStep();
  bool ShouldFinish() const;
  bool HasRoom() const;
  void DropOldest();

  void Open();
  absl::StatusOr<Caller> Authorize(const v1::OpenSession& open) const;
  void OpenNew(Caller caller);
  void Resume(const Caller& caller);
  void Opened(std::shared_ptr<Session> session, bool resumed);
  void Fail(grpc::Status status);
  void Process();
  grpc::Status Answer(Session& session, Slot& slot, bool dropped) const;
  std::string EndReason() const;
  void LetGo(const Session& session, bool keep, const std::string& reason) const;

  Slot& SlotAt(std::int64_t index) {
    return slots_[static_cast<std::size_t>(index) % slots_.size()];
  }

  const SessionHost& host_;
  grpc::CallbackServerContext* const context_;
  std::function<void(LocalizeStream*)> on_done_;
  std::shared_ptr<LocalizeStream> self_;  ///< reset by OnDone

  mutable std::mutex mutex_;
  std::vector<Slot> slots_;
  std::shared_ptr<Session> session_;  ///< none before it is open and after it was let go
  bool resumable_ = false;
  bool resumed_ = false;
  bool drops_oldest_ = false;
  // How many requests were read, answered and written; written <= answered <= read.
  std::int64_t read_count_ = 0;
  std::int64_t answered_count_ = 0;
  std::int64_t written_count_ = 0;
  std::optional<v1::LocalizeResponse> announcement_;  ///< at most one, written once
  bool pumping_ = false;
  bool reading_ = false;
  bool writing_ = false;
  bool announcing_ = false;  ///< what is being written is the announcement
  bool announced_ = false;
  bool opening_ = false;  ///< a task may use the context, so the call may not end yet
  bool processing_ = false;
  bool draining_ = false;   ///< reads no more, the rest is answered
  bool over_ = false;       ///< the session ends with the stream: closed, failed or ended
  bool failed_ = false;     ///< a request ended the call, the rest is dropped
  bool cancelled_ = false;  ///< nobody listens any more
  bool finished_ = false;
  grpc::Status final_status_;
};

}  // namespace dcloc::server
