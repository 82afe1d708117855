#pragma once

#include <memory>
#include <optional>

#include "dcloc/v1/map_service.pb.h"
#include "server/maps/jobs/upload.h"
#include "server/rpc/read_stream.h"

namespace dcloc::server {

/// One UploadMap call: each chunk is written to disk before the next one is read.
class UploadStream final : public ReadStream<v1::UploadMapRequest, v1::UploadMapResponse> {
 public:
  static UploadStream* Start(grpc::CallbackServerContext* context, const RpcContext& host,
                             grpc::ByteBuffer* response);

 private:
  using ReadStream::ReadStream;

  absl::Status Take(const v1::UploadMapRequest& request) override;
  absl::Status Complete(v1::UploadMapResponse* response) override;
  void Release() override { upload_.reset(); }

  absl::Status TakeHeader(const v1::UploadMapHeader& header);

  std::optional<Upload> upload_;
};

}  // namespace dcloc::server
