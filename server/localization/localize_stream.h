#pragma once

#include <grpcpp/support/server_callback.h>

#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "dcloc/v1/localization_service.pb.h"
#include "server/base/peer_wait.h"
#include "server/localization/attach_session.h"
#include "server/localization/slot_ring.h"
#include "server/localization/stream_context.h"
#include "server/localization/stream_state.h"
#include "server/sessions/session_stream.h"

namespace dcloc::server {

class LocalizeStream;

/// Who keeps the streams. Outlives them.
class StreamKeeper {
 public:
  virtual ~StreamKeeper() = default;

  /// The stream's caller may localize; its first message is awaited now.
  virtual void OnAdmitted(LocalizeStream& stream, const Principal& principal) = 0;

  /// The stream's first message has come.
  virtual void OnFirstMessage(LocalizeStream& stream) = 0;

  /// gRPC is done with the stream's call; called once.
  virtual void OnDone(LocalizeStream& stream) = 0;
};

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
class LocalizeStream final : public grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                             public SessionStream,
                             public PeerBoundCall,
                             public std::enable_shared_from_this<LocalizeStream> {
 public:
  /// Lives until the call is done and no task of the pools refers to it. `context` outlives the
  /// call. Nothing happens before `Admit`.
  static std::shared_ptr<LocalizeStream> Create(const StreamContext& host,
                                                grpc::CallbackServerContext* context,
                                                StreamKeeper& keeper);

  /// Has it checked, on the pool, whether the caller may localize. Only then is anything read. From
  /// here on gRPC has it.
  void Admit();

  void Announce(const v1::SessionEnding& ending) override;
  void End(grpc::Status status) override;
  void Displace(grpc::Status status) override;
  void Abort() override;

  /// Ends a stream whose `open` does not come, and cuts off one whose answers are not read.
  void CheckPeer(PeerWait::Clock::time_point now) override;

  /// Whether the client asked for a resumable session.
  bool resumable() const;

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

 private:
  enum class Step { kNone, kRead, kWrite, kAnnounce, kFinish };
  enum class WriteUnderWay { kNone, kAnswer, kAnnouncement };

  /// That the server will end the session is told at most once; the first word counts.
  enum class Announcement { kNone, kWaiting, kWritten };

  /// What a pool does for the stream, in this order, and the last again and again.
  enum class Task { kNone, kAdmission, kOpening, kScan };

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
    std::string reason;  ///< for clients that ask for the session later
  };

  LocalizeStream(const StreamContext& host, grpc::CallbackServerContext* context,
                 StreamKeeper& keeper);

  // With the mutex held.
  StreamAction Take(StreamEvent event);
  void TakeStatus(StreamEvent event, grpc::Status status);
  StreamEvent EventOfRead(bool ok);
  void TakeRead(bool ok);
  void QueueScan();
  void Attach(const AttachedSession& attached);
  bool AnnouncementIsDue() const;
  bool UsesContext() const;
  bool IsSettled() const;
  Step TakeWrite();
  Step TakeStep();
  void Describe(Ending& ending) const;

  void Pump();
  void Write(const v1::LocalizeResponse& response);
  void FinishWith(Ending ending);

  absl::Status Authorize();
  void CheckCaller();
  void Open();
  void Opened(AttachedSession attached);
  void Fail(grpc::Status status);
  void AnswerNext();
  absl::Status Answer(Session& session, Slot& slot, Handling handling) const;

  const StreamContext& host_;
  grpc::CallbackServerContext* const context_;
  StreamKeeper& keeper_;
  std::shared_ptr<LocalizeStream> self_;  ///< from `Admit` to `OnDone`

  mutable std::mutex mutex_;
  StreamState state_ = StreamState::kAdmitting;
  Principal principal_;  ///< from kOpening on
  PeerWait peer_wait_;   ///< for the first message, then for each answer to be read
  SlotRing ring_;
  grpc::ByteBuffer incoming_;         ///< the transport's while a read is under way
  std::size_t incoming_bytes_ = 0;    ///< of the newest message
  grpc::ByteBuffer outgoing_;         ///< the transport's while a write is under way
  std::shared_ptr<Session> session_;  ///< none before it is open and after it was let go
  Terms terms_;
  grpc::Status final_status_;
  std::optional<Ending> ending_;  ///< from kSettled to Finish
  Announcement announcement_ = Announcement::kNone;
  v1::LocalizeResponse announced_;  ///< the message, unless there is none

  // What is under way. These are facts of the transport and of the pools, not of the state: in most
  // states each of them may be so or not, whatever the others are, and no event but its own end
  // changes it.
  Task task_under_way_ = Task::kAdmission;
  WriteUnderWay write_under_way_ = WriteUnderWay::kNone;
  bool read_under_way_ = false;
  bool pump_under_way_ = false;  ///< the thread in `Pump` checks the state again before it leaves
};

}  // namespace dcloc::server
