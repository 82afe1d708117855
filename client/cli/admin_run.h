#pragma once

#include <functional>
#include <memory>

#include "absl/status/status.h"
#include "client/sdk/admin_client.h"
#include "client/sdk/channel.h"

namespace dcloc::cli {

/// Makes a client of the server and runs `work` with it; an error of the connection names the
/// server.
absl::Status WithAdminClient(const client::ChannelOptions& server,
                             const std::function<absl::Status(client::AdminClient&)>& work);

/// The open session that `text` means: an id, the beginning of just one, or the vehicle of just
/// one. NotFound, or InvalidArgument naming those that it could be.
absl::StatusOr<v1::Session> FindSession(client::AdminClient& admin, const std::string& text);

}  // namespace dcloc::cli
