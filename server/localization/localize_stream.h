#pragma once

#include <grpcpp/support/server_callback.h>

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "dcloc/v1/localization_service.pb.h"
#include "server/localization/attach_session.h"
#include "server/localization/session_host.h"
#include "server/localization/slot_ring.h"
#include "server/localization/stream_state.h"
#include "server/sessions/session_stream.h"

namespace dcloc::server {

/// One Localize call: the stream to which a session is attached, or will be.
///
/// Its messages go through a ring of slots: read, answered on the session's strand, written, free
/// again. Each scan gets exactly one answer. The next read starts only when a slot is free. If the
/// client asked for the oldest scans to be dropped, the ring is longer; a dropped scan is marked,
/// and its answer comes in its turn.
///
/// Events of the transport, of the pool and of a shutdown change the state (stream_state.h) under
/// the mutex. Then `Pump` starts the reads and writes that the state allows. Only one thread at a
/// time runs `Pump`, and it holds no lock while it calls gRPC. So there is one write at a time, and
/// no call follows `Finish`.
class LocalizeStream final
    : public grpc::ServerBidiReactor<v1::LocalizeRequest, v1::LocalizeResponse>,
      public SessionStream,
      public std::enable_shared_from_this<LocalizeStream> {
 public:
  /// Lives until the call is done and no task of the pools refers to it. `on_done` is called once,
  /// when gRPC is done with the call. `context` outlives the call.
  static std::shared_ptr<LocalizeStream> Start(const SessionHost& host,
                                               grpc::CallbackServerContext* context,
                                               std::function<void(LocalizeStream*)> on_done);

  void Announce(const v1::SessionEnding& ending) override;
  void End(grpc::Status status) override;
  void Displace(grpc::Status status) override;
  void Abort() override;

  /// Whether the client asked for a resumable session.
  bool resumable() const;

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

 private:
  enum class Step { kNone, kRead, kWrite, kAnnounce, kFinish };
  enum class Write { kNone, kAnswer, kAnnouncement };

  /// What was agreed when the session was opened or resumed.
  struct Terms {
    bool resumable = false;
    bool drops_oldest = false;
    bool resumed = false;
  };

  /// How a call ends, for the client and for the session.
  struct Ending {
    grpc::Status status;
    std::shared_ptr<Session> session;  ///< null where there is none to let go of
    bool keeps_session = false;
    std::string reason;  ///< told to clients that ask for the session later
  };

  LocalizeStream(const SessionHost& host, grpc::CallbackServerContext* context,
                 std::function<void(LocalizeStream*)> on_done);

  // With the mutex held.
  StreamAction Take(StreamEvent event);
  void TakeStatus(StreamEvent event, grpc::Status status);
  StreamEvent EventOfRead(bool ok);
  void QueueScan();
  void Attach(AttachedSession attached);
  bool AnnouncementIsDue() const;
  bool IsSettled() const;
  Step TakeStep();
  Ending TakeEnding();

  void Pump();
  void FinishWith(Ending ending);

  void Open();
  void Opened(AttachedSession attached);
  void Fail(grpc::Status status);
  void AnswerNext();
  grpc::Status Answer(Session& session, Slot& slot, bool dropped) const;

  const SessionHost& host_;
  grpc::CallbackServerContext* const context_;
  std::function<void(LocalizeStream*)> on_done_;
  std::shared_ptr<LocalizeStream> self_;  ///< reset by OnDone

  mutable std::mutex mutex_;
  StreamState state_ = StreamState::kOpening;
  SlotRing ring_;
  std::shared_ptr<Session> session_;  ///< none before it is open and after it was let go
  Terms terms_;
  grpc::Status final_status_;
  std::optional<Ending> ending_;                      ///< from kSettled to Finish
  std::optional<v1::LocalizeResponse> announcement_;  ///< at most one, written once
  bool announced_ = false;

  // What is under way, whatever the state.
  bool open_under_way_ = false;  ///< a task may use the context, so the call may not end yet
  bool read_under_way_ = false;
  Write write_under_way_ = Write::kNone;
  bool answer_under_way_ = false;  ///< a scan is being localized
  bool pump_under_way_ = false;    ///< the thread in `Pump` checks the state again before it leaves
};

}  // namespace dcloc::server
