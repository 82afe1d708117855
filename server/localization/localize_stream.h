#pragma once

#include <grpcpp/support/server_callback.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "dcloc/v1/localization_service.pb.h"
#include "server/localization/session.h"
#include "server/storage_host.h"
#include "server/worker_pool.h"

namespace dcloc::server {

/// What all streams share; outlives them.
struct SessionHost {
  const StorageHost& storage;  ///< opening a session may wait for a disk
  SessionRegistry& registry;
  MatcherFactory* create_matcher;
  WorkerPool& localization_pool;  ///< answers scans
  int max_pending_scan_count;     ///< per session
};

/// One Localize call.
///
/// Its requests go through a ring of slots: read, answered on the pool, written, free again. A
/// slot's request and response are used over and over, each request gets exactly one response, and
/// the next read starts only when a slot is free, so that neither a fast writer nor a slow reader
/// can make the server's memory grow.
///
/// The transport's events, the pool's and a shutdown change the state under the mutex, and then
/// `Pump` starts what the state allows. Only one thread at a time is in it, and it holds no lock
/// while it calls gRPC: there is one write at a time, and nothing can follow `Finish`.
class LocalizeStream final
    : public grpc::ServerBidiReactor<v1::LocalizeRequest, v1::LocalizeResponse>,
      public std::enable_shared_from_this<LocalizeStream> {
 public:
  /// Lives until the call is done and the pools have let go of it. `on_done` is called once, when
  /// the transport has no more use for it.
  static std::shared_ptr<LocalizeStream> Start(const SessionHost& host, std::string peer,
                                               std::function<void(LocalizeStream*)> on_done);

  /// Reads no more, answers what was read, then ends the call with `status`. Thread-safe.
  void End(grpc::Status status);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

 private:
  struct Slot {
    v1::LocalizeRequest request;
    v1::LocalizeResponse response;
    std::chrono::steady_clock::time_point arrival;
  };
  enum class Step { kNone, kRead, kWrite, kFinish };

  LocalizeStream(const SessionHost& host, std::string peer,
                 std::function<void(LocalizeStream*)> on_done);

  void Pump();
  Step TakeStep();
  bool ShouldFinish() const;
  bool HasRoom() const;

  void Process();
  grpc::Status Answer(Slot& slot);
  grpc::Status OpenSession(Slot& slot);

  Slot& SlotAt(std::int64_t index) {
    return slots_[static_cast<std::size_t>(index) % slots_.size()];
  }

  const SessionHost& host_;
  const std::string peer_;
  std::function<void(LocalizeStream*)> on_done_;
  std::shared_ptr<LocalizeStream> self_;  ///< reset by OnDone
  std::vector<Slot> slots_;
  Strand strand_;
  std::unique_ptr<Session> session_;  ///< of the task that runs; one at a time

  std::mutex mutex_;
  // How many requests were read, answered and written; written <= answered <= read.
  std::int64_t read_count_ = 0;
  std::int64_t answered_count_ = 0;
  std::int64_t written_count_ = 0;
  bool pumping_ = false;
  bool reading_ = false;
  bool writing_ = false;
  bool draining_ = false;   ///< reads no more, the rest is answered
  bool failed_ = false;     ///< a request ended the call, the rest is dropped
  bool cancelled_ = false;  ///< nobody listens any more
  bool finished_ = false;
  grpc::Status final_status_;
};

}  // namespace dcloc::server
