#include "server/replicas/replica_channels.h"

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>

#include <algorithm>
#include <utility>

#include "server/base/small_file.h"
#include "server/base/status.h"

namespace dcloc::server {
namespace {

/// A replica whose machine is gone is noticed by the streams that are relayed from it.
constexpr int kKeepaliveTime_ms = 10'000;
constexpr int kKeepaliveTimeout_ms = 5'000;
constexpr int kMaxReconnectBackoff_ms = 1'000;
constexpr int kMaxMessage_bytes = 64 << 20;  ///< far above a page of sessions and a recorded scan

grpc::ChannelArguments Arguments() {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(kMaxMessage_bytes);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, kKeepaliveTime_ms);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kKeepaliveTimeout_ms);
  // A relayed stream sends nothing after its request.
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  // A proxy that the environment names must not see callers' tokens.
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, kMaxReconnectBackoff_ms);
  return arguments;
}

}  // namespace

absl::StatusOr<std::shared_ptr<grpc::Channel>> ReplicaChannels::To(const std::string& address) {
  absl::StatusOr<Files> files = ReadFiles();
  if (!files.ok()) return files.status();
  const std::lock_guard lock(mutex_);
  if (files_ != *files) channels_.clear();
  files_ = *std::move(files);
  std::shared_ptr<grpc::Channel>& channel = channels_[address];
  if (channel == nullptr) {
    const auto credentials = tls_.enabled ? grpc::SslCredentials({.pem_root_certs = files_.ca,
                                                                  .pem_private_key = files_.key,
                                                                  .pem_cert_chain = files_.cert})
                                          : grpc::InsecureChannelCredentials();
    channel = grpc::CreateCustomChannel(address, credentials, Arguments());
  }
  return channel;
}

void ReplicaChannels::KeepOnly(const std::vector<std::string>& addresses) {
  const std::lock_guard lock(mutex_);
  std::erase_if(channels_, [&addresses](const auto& entry) {
    return !std::ranges::binary_search(addresses, entry.first);
  });
}

std::size_t ReplicaChannels::count() const {
  const std::lock_guard lock(mutex_);
  return channels_.size();
}

absl::StatusOr<ReplicaChannels::Files> ReplicaChannels::ReadFiles() const {
  Files files;
  if (!tls_.enabled) return files;
  for (const auto& [path, text] :
       {std::pair(&tls_.ca, &files.ca), std::pair(&tls_.cert, &files.cert),
        std::pair(&tls_.key, &files.key)}) {
    if (path->empty()) continue;
    absl::StatusOr<std::string> read = ReadSmallFile(*path);
    if (!read.ok()) return WithPrefix("replica: ", read.status());
    *text = *std::move(read);
  }
  return files;
}

}  // namespace dcloc::server
