#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/server_callback.h>

#include <cstddef>
#include <memory>

#include "dcloc/v1/map_service.pb.h"
#include "server/rpc/storage_host.h"

namespace dcloc::server {

/// One DownloadMap call: a message is filled on the call's strand, written, and then the next one
/// is filled. The version counts as in use meanwhile.
class DownloadStream final : public grpc::ServerWriteReactor<v1::DownloadMapResponse>,
                             public std::enable_shared_from_this<DownloadStream> {
 public:
  /// Lives until the call is done and the pool has let go of it.
  static DownloadStream* Start(const StorageHost& host, grpc::CallbackServerContext* context,
                               const v1::DownloadMapRequest& request);

  void OnWriteDone(bool ok) override;
  void OnDone() override;

 private:
  explicit DownloadStream(const StorageHost& host);

  void SendVersion(const grpc::CallbackServerContext& context,
                   const v1::DownloadMapRequest& request);
  void SendChunk();
  void End(const absl::Status& status);

  const StorageHost& host_;
  OpenCalls::Token token_;
  Strand strand_;
  std::shared_ptr<DownloadStream> self_;  ///< reset by OnDone
  LoadedMap map_;
  std::size_t sent_bytes_ = 0;
  v1::DownloadMapResponse response_;
};

}  // namespace dcloc::server
