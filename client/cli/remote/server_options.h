#pragma once

#include <CLI/CLI.hpp>

#include "absl/status/status.h"
#include "client/sdk/channel.h"

namespace dcloc::cli {

/// Adds --server, --token-file, --tenant and --tls-ca, --tls-cert, --tls-key, --tls-server-name to
/// `command`; fills `options` when it is parsed. Gives --server, which is required.
CLI::Option* AddServerOptions(CLI::App& command, client::ChannelOptions& options);

/// `status`; an error of the connection, which need not say with whom, then names the server.
absl::Status NamingServer(absl::Status status, const client::ChannelOptions& server);

}  // namespace dcloc::cli
