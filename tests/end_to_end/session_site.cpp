#include "tests/end_to_end/session_site.h"

#include <stop_token>
#include <thread>
#include <utility>

#include "client/sdk/admin_client.h"
#include "client/sdk/channel.h"
#include "client/sdk/map_client.h"

namespace dcloc {
namespace {

int PortOf(const std::string& address) { return std::stoi(address.substr(address.rfind(':') + 1)); }

}  // namespace

absl::Status SessionSite::Start(const std::vector<std::byte>& map) {
  if (absl::Status status = StartServer(); !status.ok()) return status;
  proxy_ = std::make_unique<client::TcpProxy>(PortOf(server_->address()));
  return client::MapClient(server_->Channel())
      .Upload(folder_.Write("town.dclm", map), "town", {.activate = true})
      .status();
}

absl::Status SessionSite::Restart(End end) {
  if (end == End::kKilled) {
    server_->Kill();
  } else if (!server_->Terminate()) {
    return absl::InternalError("the server did not end as it should");
  }
  if (absl::Status status = StartServer(); !status.ok()) return status;
  proxy_->SetTarget(PortOf(server_->address()));
  return absl::OkStatus();
}

absl::Status SessionSite::StartServer() {
  server_ = std::make_unique<ServerProcess>(
      program_, folder_.path() / "store", folder_.path() / "log",
      ServerProcessOptions{.stub_localizer = localizer_ == Localizer::kStub});
  if (!server_->WaitUntilReady()) return absl::InternalError("the server did not start");
  if (localizer_ == Localizer::kMethod) recordings_.push_back(Record());
  return absl::OkStatus();
}

SessionSite::Recording SessionSite::Record() const {
  std::promise<void> ready;
  std::future<void> is_ready = ready.get_future();
  Recording recording =
      std::async(std::launch::async,
                 [vehicle_id = vehicle_id_, channel = server_->Channel(),
                  ready = std::move(ready)]() mutable -> absl::StatusOr<RecordedSession> {
                   RecordedSession session;
                   absl::Status status = client::AdminClient(channel).RecordSession(
                       vehicle_id, std::stop_token(), [&] { ready.set_value(); },
                       [&](const v1::RecordSessionResponse& message) {
                         if (message.has_header()) session.header = message.header();
                         if (message.has_scan()) session.scans.push_back(message.scan());
                       });
                   if (!status.ok()) return status;
                   return session;
                 });
  is_ready.wait();
  return recording;
}

std::shared_ptr<grpc::Channel> SessionSite::Channel() const {
  return *client::MakeChannel({.server = proxy_->address()});
}

absl::StatusOr<std::vector<RecordedSession>> SessionSite::TakeRecordings() {
  std::vector<RecordedSession> sessions;
  for (Recording& recording : std::exchange(recordings_, {})) {
    absl::StatusOr<RecordedSession> session = recording.get();
    if (!session.ok()) return session.status();
    sessions.push_back(*std::move(session));
  }
  return sessions;
}

}  // namespace dcloc
