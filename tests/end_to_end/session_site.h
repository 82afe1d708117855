#pragma once

#include <grpcpp/channel.h>

#include <chrono>
#include <filesystem>
#include <future>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "dcloc/v1/recording.pb.h"
#include "tests/client/sdk/tcp_proxy.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/end_to_end/server_process.h"

namespace dcloc {

/// One session as the server saw it.
struct RecordedSession {
  v1::RecordingHeader header;
  std::vector<v1::RecordedScan> scans;
};

/// A server's process that can be restarted, behind a proxy that can be cut. With the method, all
/// sessions of one vehicle are recorded by the server.
class SessionSite {
 public:
  /// What localizes: the method, or the stub, which costs nothing.
  enum class Localizer { kMethod, kStub };
  /// How a server's process ends.
  enum class End { kTerminated, kKilled };

  SessionSite(std::string program, std::string vehicle_id, Localizer localizer)
      : program_(std::move(program)), vehicle_id_(std::move(vehicle_id)), localizer_(localizer) {}

  /// The first server, with a map named "town".
  absl::Status Start(const std::vector<std::byte>& map);

  /// Ends the server by SIGTERM or SIGKILL and starts another one on its store; who connects to the
  /// proxy finds it. Internal when the process did not end as it should.
  absl::Status Restart(End end);

  /// Resets all connections through the proxy.
  void Cut() { proxy_->Cut(); }

  /// Through the proxy.
  std::shared_ptr<grpc::Channel> Channel() const;

  /// The vehicle's sessions, in their order, once they have ended.
  absl::StatusOr<std::vector<RecordedSession>> TakeRecordings();

 private:
  using Recording = std::future<absl::StatusOr<RecordedSession>>;

  absl::Status StartServer();
  Recording Record() const;

  const TemporaryFolder folder_;
  const std::string program_;
  const std::string vehicle_id_;
  const Localizer localizer_;
  // Before the server: letting go of one waits for its end, which may be the server's.
  std::vector<Recording> recordings_;
  std::unique_ptr<ServerProcess> server_;
  std::unique_ptr<client::TcpProxy> proxy_;
};

}  // namespace dcloc
