#pragma once

#include <grpcpp/channel.h>

#include <memory>
#include <string>

#include "absl/status/statusor.h"

namespace dcloc::client {

/// The address of the server, and how to connect to it.
struct ChannelOptions {
  std::string server;  ///< HOST:PORT

  /// PEM files. With none of them the channel is plaintext.
  std::string tls_ca;    ///< authorities that may have signed the server's certificate
  std::string tls_cert;  ///< the client's own certificate, where the server asks for one (mTLS)
  std::string tls_key;   ///< its private key
  /// The name in the server's certificate, where it is not the host of `server`.
  std::string tls_server_name;

  /// A file with the caller's bearer token; read once. The token is only sent over TLS, or in
  /// plaintext to the same machine.
  std::string token_file;

  /// The tenant to work in, for who may manage the server; empty: the caller's own. Its letters are
  /// those of a map's name.
  std::string tenant;

  /// Has a connection of its own. Otherwise channels with equal options share one.
  bool own_connection = false;
};

/// A channel with the limits and keepalive that suit a dcloc server. Does not connect: an
/// unreachable server causes an error on first use. InvalidArgument names the option; a file that
/// cannot be read is named with the reason.
absl::StatusOr<std::shared_ptr<grpc::Channel>> MakeChannel(const ChannelOptions& options);

}  // namespace dcloc::client
