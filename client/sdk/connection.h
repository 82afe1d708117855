#pragma once

#include <grpcpp/client_context.h>
#include <grpcpp/support/client_callback.h>

#include <mutex>

#include "dcloc/v1/localization_service.grpc.pb.h"

namespace dcloc::client {

/// One Localize call, from its `open` to its status. It obeys gRPC's rules. At most one write and
/// one read are under way. A hold is kept while threads outside of the reactions may start
/// operations, and given back once, when the read side has ended. Nothing is touched after OnDone.
class Connection final : public grpc::ClientBidiReactor<v1::LocalizeRequest, v1::LocalizeResponse> {
 public:
  enum class Fill { kRequest, kNothingYet, kNothingMore };

  /// Whose stream it is. All are called with the host's mutex held.
  class Host {
   public:
    virtual ~Host() = default;
    /// The next request to write, if there is one.
    virtual Fill FillRequest(v1::LocalizeRequest* request) = 0;
    /// Whether one more response can be taken.
    virtual bool HasRoom() const = 0;
    virtual void Take(v1::LocalizeResponse response) = 0;
    /// The last call; the connection may go once the mutex is free.
    virtual void OnEnd(const grpc::Status& status) = 0;
  };

  /// Starts the call. The host, whose mutex is held here and in all other calls, outlives it, and
  /// deletes it after `OnEnd` and not before.
  Connection(v1::LocalizationService::Stub& stub, std::mutex& mutex, Host& host,
             const v1::OpenSession& open);

  /// Starts the next write if there is one and none is under way.
  void WriteOn();
  /// Starts the next read if there is room for what it brings and none is under way.
  void ReadOn();
  /// Ends the call without waiting for what is under way.
  void Cancel();

  void OnWriteDone(bool ok) override;
  void OnReadDone(bool ok) override;
  void OnDone(const grpc::Status& status) override;

 private:
  /// One direction of the stream. Either ends on its own, and nothing is started on it again.
  enum class Side { kIdle, kUnderWay, kEnded };

  std::mutex& mutex_;
  Host& host_;
  grpc::ClientContext context_;
  v1::LocalizeRequest request_;    ///< the transport's while a write is under way
  v1::LocalizeResponse response_;  ///< the transport's while a read is under way
  Side write_ = Side::kUnderWay;
  Side read_ = Side::kUnderWay;
};

}  // namespace dcloc::client
