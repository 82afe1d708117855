#pragma once

#include <grpcpp/server_context.h>

#include <memory>
#include <optional>

#include "dcloc/v1/map_service.pb.h"
#include "server/maps/jobs/upload.h"
#include "server/rpc/storage_host.h"

namespace dcloc::server {

/// One UploadMap call: each message is read, then written to disk on the call's strand, and only
/// then the next one is read.
class UploadStream final : public grpc::ServerReadReactor<v1::UploadMapRequest>,
                           public std::enable_shared_from_this<UploadStream> {
 public:
  /// Lives until the call is done and the pool has let go of it.
  static UploadStream* Start(grpc::CallbackServerContext* context, const StorageHost& host,
                             v1::UploadMapResponse* response);

  void OnReadDone(bool ok) override;
  void OnDone() override;

 private:
  UploadStream(grpc::CallbackServerContext* context, const StorageHost& host,
               v1::UploadMapResponse* response);

  void TakeMessage();
  void TakeEnd();
  absl::Status Take(const v1::UploadMapRequest& request);
  absl::Status Begin(const v1::UploadMapHeader& header);

  grpc::CallbackServerContext* context_;
  const StorageHost& host_;
  OpenCalls::Token token_;
  Strand strand_;
  v1::UploadMapResponse* response_;
  std::shared_ptr<UploadStream> self_;  ///< reset by OnDone
  v1::UploadMapRequest request_;
  std::optional<Upload> upload_;
};

}  // namespace dcloc::server
