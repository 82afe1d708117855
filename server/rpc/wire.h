#pragma once

#include <grpcpp/impl/codegen/proto_utils.h>
#include <grpcpp/support/byte_buffer.h>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "server/base/within_memory.h"

namespace dcloc::server {

/// Parses a message as it came, and takes its bytes. InvalidArgument if they are none of its type,
/// `OutOfMemory` without memory for it.
///
/// gRPC itself tells a streamed message that does not parse from the stream's end by nothing.
template <typename Message>
absl::Status ParseMessage(grpc::ByteBuffer* bytes, Message* message) {
  return FillWithinMemory(message, [&]() -> absl::Status {
    if (grpc::SerializationTraits<Message>::Deserialize(bytes, message).ok()) {
      return absl::OkStatus();
    }
    return absl::InvalidArgumentError(
        absl::StrCat("the message does not parse as ", Message::descriptor()->full_name()));
  });
}

/// A message as it is sent.
template <typename Message>
grpc::ByteBuffer SerializeMessage(const Message& message) {
  grpc::ByteBuffer bytes;
  bool own = false;
  grpc::SerializationTraits<Message>::Serialize(message, &bytes, &own);
  return bytes;
}

}  // namespace dcloc::server
