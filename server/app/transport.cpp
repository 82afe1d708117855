#include "server/app/transport.h"

#include <grpcpp/resource_quota.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "server/rpc/unparsed_requests.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

constexpr int kMaxMetadata_bytes = 16 << 10;
/// What a stream may send before it is read; a message that is awaited comes whole.
constexpr int kUnreadOfStream_bytes = 256 << 10;
/// A vehicle that is gone is noticed within their sum; clients may ping as often as the minimum.
constexpr int kKeepaliveTime_ms = 30'000;
constexpr int kKeepaliveTimeout_ms = 10'000;
constexpr int kMinClientPingInterval_ms = 5'000;
constexpr int kMaxConnectionIdle_ms = 300'000;
constexpr int kOtherStreamsPerConnection = 100;
/// Of gRPC's own services, of which reflection alone has calls that hold one; a few only wait.
constexpr int kMaxReflectionThreads = 16;

void SetLimits(const ServerConfig& config, grpc::ServerBuilder& builder) {
  builder.SetMaxReceiveMessageSize(config.max_message_kib << 10);
  builder.SetMaxSendMessageSize(config.max_message_kib << 10);
  // gRPC unpacks a message before it looks at its size, and 2 MiB may unpack to 2 GiB. A call of
  // packed messages is UNIMPLEMENTED; one that only claims to have none is not unpacked.
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
  builder.AddChannelArgument(GRPC_ARG_ENABLE_PER_MESSAGE_DECOMPRESSION, 0);
  builder.SetResourceQuota(grpc::ResourceQuota("dcloc").SetMaxThreads(kMaxReflectionThreads));
  // gRPC would take some 20 MiB of each stream in advance, where much is sent.
  builder.AddChannelArgument(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, kUnreadOfStream_bytes);
  builder.AddChannelArgument(GRPC_ARG_MAX_METADATA_SIZE, kMaxMetadata_bytes);
  // All sessions may come over one connection, and some other calls beside them.
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS,
                             config.max_session_count + kOtherStreamsPerConnection);
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, config.open_timeout_ms);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_IDLE_MS, kMaxConnectionIdle_ms);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, kKeepaliveTime_ms);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kKeepaliveTimeout_ms);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS,
                             kMinClientPingInterval_ms);
}

void SetInterceptors(BoundedCalls& calls, grpc::ServerBuilder& builder) {
  std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> creators;
  creators.push_back(std::make_unique<UnparsedRequests>());
  creators.push_back(calls.Watching());
  builder.experimental().SetInterceptorCreators(std::move(creators));
}

}  // namespace

void SetUpTransport(const ServerConfig& config, BoundedCalls& calls, grpc::ServerBuilder& builder) {
  SetLimits(config, builder);
  SetInterceptors(calls, builder);
}

Listener::Bounds ConnectionBounds(const ServerConfig& config) {
  const int max = Listener::MaxDescriptor();
  const int of_a_peer = config.max_connection_count_per_peer;
  if (max < config.max_session_count) {
    spdlog::warn(
        "max_session_count is {}, and files are left for {} connections: raise the limit of open "
        "files (LimitNOFILE)",
        config.max_session_count, std::max(0, max));
  }
  return {.max_descriptor = max,
          .max_count_per_peer = of_a_peer > 0 ? of_a_peer : std::max(1, max / 2)};
}

}  // namespace dcloc::server
