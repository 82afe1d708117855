#pragma once

#include <CLI/CLI.hpp>

#include "client/sdk/channel.h"

namespace dcloc::cli {

/// Adds --server, --token-file and --tls-ca, --tls-cert, --tls-key, --tls-server-name to `command`;
/// fills `options` when it is parsed. Gives --server, which is required.
CLI::Option* AddServerOptions(CLI::App& command, client::ChannelOptions& options);

}  // namespace dcloc::cli
