#include "client/cli/remote/admin_run.h"

#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace dcloc::cli {
namespace {

constexpr std::size_t kIdSize = 32;

}  // namespace

absl::Status WithAdminClient(const client::ChannelOptions& server,
                             const std::function<absl::Status(client::AdminClient&)>& work) {
  const auto channel = client::MakeChannel(server);
  if (!channel.ok()) return channel.status();
  client::AdminClient admin(*channel);
  return NamingServer(work(admin), server);
}

absl::StatusOr<v1::Session> FindSession(client::AdminClient& admin, const std::string& text) {
  // The server knows for a while why one that is gone has ended.
  if (text.size() == kIdSize) return admin.GetSession(text);
  const absl::StatusOr<std::vector<v1::Session>> sessions = admin.ListSessions();
  if (!sessions.ok()) return sessions.status();
  std::vector<v1::Session> meant;
  std::string names;
  for (const v1::Session& session : *sessions) {
    if (session.vehicle_id() != text && !absl::StartsWith(session.session_id(), text)) continue;
    absl::StrAppend(&names, names.empty() ? "" : ", ", session.session_id(), " (",
                    session.vehicle_id(), ")");
    meant.push_back(session);
  }
  if (meant.empty()) {
    return absl::NotFoundError(absl::StrCat("no open session has the id or vehicle ", text));
  }
  if (meant.size() > 1) {
    return absl::InvalidArgumentError(absl::StrCat(text, " may mean any of ", names));
  }
  return meant.front();
}

}  // namespace dcloc::cli
