#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/server_callback.h>

#include <atomic>
#include <cstddef>
#include <memory>

#include "dcloc/v1/map_service.pb.h"
#include "server/maps/service/download_slots.h"
#include "server/rpc/rpc_context.h"

namespace dcloc::server {

/// One DownloadMap call: a message is filled on the call's strand, written, and then the next one
/// is filled. The version counts as in use meanwhile, so a caller who does not read for
/// `peer_timeout_ms` is cut off.
class DownloadStream final : public grpc::ServerWriteReactor<v1::DownloadMapResponse>,
                             public PeerBoundCall,
                             public std::enable_shared_from_this<DownloadStream> {
 public:
  /// Lives until the call is done and the pool has let go of it.
  /// `slots` outlives it.
  static DownloadStream* Start(const RpcContext& host, DownloadSlots& slots,
                               grpc::CallbackServerContext* context,
                               const v1::DownloadMapRequest& request);

  void OnWriteDone(bool ok) override;
  void OnDone() override;
  void CheckPeer(PeerWait::Clock::time_point now) override;

 private:
  DownloadStream(const RpcContext& host, DownloadSlots& slots,
                 grpc::CallbackServerContext* context);

  // On the strand.
  template <typename Work>
  void PostOrEnd(Work work);
  void SendVersion(const v1::DownloadMapRequest& request);
  absl::Status Open(const v1::DownloadMapRequest& request);
  void SendChunk();
  void Send();
  void CutOff();
  void End(const absl::Status& status);

  const RpcContext& host_;
  DownloadSlots& slots_;
  grpc::CallbackServerContext* const context_;
  OpenCalls::Token token_;
  Strand strand_;
  PeerWait peer_wait_;
  std::shared_ptr<DownloadStream> self_;  ///< reset by OnDone
  std::atomic<bool> ended_ = false;
  std::shared_ptr<void> slot_;
  LoadedMap map_;
  std::size_t sent_bytes_ = 0;
  v1::DownloadMapResponse response_;
};

}  // namespace dcloc::server
