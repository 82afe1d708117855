#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "grpcpp/channel.h"
#include "tests/client/sdk/tcp_proxy.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/end_to_end/server_process.h"

namespace dcloc {

/// Two servers of a fleet, each with a store of its own and the same map in it, behind a proxy that
/// leads to one of them.
class FailoverSite {
 public:
  explicit FailoverSite(std::string program);

  /// Both servers, with a map named "town".
  absl::Status Start(const std::vector<std::byte>& map);

  /// SIGKILL for the server in use; the proxy leads to the other one then.
  void KillOwner();

  /// The killed server is there again, on its store.
  absl::Status Revive();

  /// Through the proxy.
  std::shared_ptr<grpc::Channel> Channel() const;

  /// Writes the fleet's keys, one a line; all servers take them within some seconds.
  void WriteKeys(const std::string& lines) const;

 private:
  absl::Status StartServer(std::size_t index);

  const TemporaryFolder folder_;
  const std::string program_;
  std::array<std::unique_ptr<ServerProcess>, 2> servers_;
  std::size_t owner_ = 0;
  std::unique_ptr<client::TcpProxy> proxy_;
};

}  // namespace dcloc
