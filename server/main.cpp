#include <sys/resource.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <iostream>
#include <memory>

#include "server/command_line.h"
#include "server/server.h"
#include "spdlog/sinks/stdout_sinks.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

constexpr int kUsageError = 2;

void SetUpLog(const ServerConfig& config) {
  auto log =
      std::make_shared<spdlog::logger>("dcloc", std::make_shared<spdlog::sinks::stderr_sink_mt>());
  spdlog::set_default_logger(std::move(log));
  spdlog::set_pattern("%Y-%m-%dT%H:%M:%S.%eZ %l %v", spdlog::pattern_time_type::utc);
  spdlog::set_level(spdlog::level::from_str(config.log_level));
}

/// A connection takes a file descriptor, and this version of gRPC never accepts again once they
/// have run out.
void RaiseFileLimit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  if (setrlimit(RLIMIT_NOFILE, &limit) != 0) {
    spdlog::warn("file limit not raised");
  }
}

/// Threads inherit the mask, so this comes before there are any.
sigset_t BlockStopSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

int Run(const ServerConfig& config) {
  SetUpLog(config);
  RaiseFileLimit();
  const sigset_t stop_signals = BlockStopSignals();
  const absl::StatusOr<std::unique_ptr<Server>> server = Server::Start(config);
  if (!server.ok()) {
    std::cerr << "dcloc-server: " << server.status().message() << "\n";
    return EXIT_FAILURE;
  }
  if (config.stub_matcher) spdlog::warn("stub matcher: scans are not matched, poses mean nothing");
  // Whoever started the program may wait for this line.
  std::cout << "listening on " << (*server)->address() << std::endl;

  int signal = 0;
  sigwait(&stop_signals, &signal);
  spdlog::info("stopping signal={} deadline_ms={}", signal, config.shutdown_deadline_ms);
  (*server)->Shutdown(std::chrono::milliseconds(config.shutdown_deadline_ms));
  spdlog::info("stopped");
  return EXIT_SUCCESS;
}

int Main(int argc, const char* const* argv) {
  const absl::StatusOr<CommandLine> command_line = ParseCommandLine(argc, argv);
  if (!command_line.ok()) {
    std::cerr << "dcloc-server: " << command_line.status().message()
              << "\nRun dcloc-server --help for usage.\n";
    return kUsageError;
  }
  if (command_line->print) {
    std::cout << *command_line->print;
    return EXIT_SUCCESS;
  }
  return Run(command_line->config);
}

}  // namespace
}  // namespace dcloc::server

int main(int argc, char** argv) { return dcloc::server::Main(argc, argv); }
