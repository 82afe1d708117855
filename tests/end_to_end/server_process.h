#pragma once

#include <grpcpp/channel.h>
#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace dcloc {

struct ServerProcessOptions {
  std::uint64_t max_file_bytes = 0;  ///< the disk takes no larger files; 0: it does
  bool stub_localizer = true;
  std::vector<std::string> arguments;  ///< further ones
};

/// The dcloc-server program as a process of its own, on a free port and a given store. Its log goes
/// to a file.
class ServerProcess {
 public:
  ServerProcess(const std::string& program, const std::filesystem::path& store,
                const std::filesystem::path& log, const ServerProcessOptions& options = {});
  ServerProcess(const ServerProcess&) = delete;
  ServerProcess& operator=(const ServerProcess&) = delete;
  ~ServerProcess() { Kill(); }

  /// Waits until it listens; false when it ended instead.
  bool WaitUntilReady();

  /// HOST:PORT.
  const std::string& address() const { return address_; }

  /// A connection of its own.
  std::shared_ptr<grpc::Channel> Channel() const;

  /// What it holds in memory, mapped files among it.
  double ResidentMebibytes() const;

  /// Of processors, as user and as system, in steps of 10 ms.
  double ProcessorSeconds() const;

  /// SIGKILL, and waits for the end.
  void Kill();

  /// SIGTERM, and waits for the end; whether it ended as it should.
  bool Terminate();

 private:
  int End(int signal);

  pid_t pid_ = -1;
  int output_ = -1;
  std::string address_;
};

}  // namespace dcloc
