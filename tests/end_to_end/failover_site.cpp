#include "tests/end_to_end/failover_site.h"

#include <filesystem>
#include <fstream>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/sdk/channel.h"
#include "client/sdk/map_client.h"

namespace dcloc {
namespace {

int PortOf(const std::string& address) { return std::stoi(address.substr(address.rfind(':') + 1)); }

}  // namespace

FailoverSite::FailoverSite(std::string program) : program_(std::move(program)) {
  WriteKeys(absl::StrCat("first ", std::string(64, '5'), "\n"));
}

void FailoverSite::WriteKeys(const std::string& lines) const {
  const std::filesystem::path file = folder_.path() / "keys";
  std::ofstream(file) << lines;
  std::filesystem::permissions(
      file, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
}

absl::Status FailoverSite::StartServer(std::size_t index) {
  const std::string name = absl::StrCat("replica-", index);
  servers_[index] = std::make_unique<ServerProcess>(
      program_, folder_.path() / name, folder_.path() / absl::StrCat(name, ".log"),
      ServerProcessOptions{.stub_localizer = false,
                           .arguments = {"--ticket-keys", folder_.path() / "keys"}});
  if (servers_[index]->WaitUntilReady()) return absl::OkStatus();
  return absl::InternalError(absl::StrCat(name, " did not start"));
}

absl::Status FailoverSite::Start(const std::vector<std::byte>& map) {
  const std::filesystem::path file = folder_.Write("town.dclm", map);
  for (std::size_t i = 0; i < servers_.size(); ++i) {
    if (absl::Status status = StartServer(i); !status.ok()) return status;
    const auto uploaded =
        client::MapClient(servers_[i]->Channel()).Upload(file, "town", {.activate = true});
    if (!uploaded.ok()) return uploaded.status();
  }
  proxy_ = std::make_unique<client::TcpProxy>(PortOf(servers_[owner_]->address()));
  return absl::OkStatus();
}

void FailoverSite::KillOwner() {
  const std::size_t other = 1 - owner_;
  proxy_->SetTarget(PortOf(servers_[other]->address()));
  servers_[owner_]->Kill();
  proxy_->Cut();
  owner_ = other;
}

absl::Status FailoverSite::Revive() { return StartServer(1 - owner_); }

std::shared_ptr<grpc::Channel> FailoverSite::Channel() const {
  return *client::MakeChannel({.server = proxy_->address()});
}

}  // namespace dcloc
