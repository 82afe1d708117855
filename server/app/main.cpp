#include <malloc.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <thread>

#include "absl/synchronization/mutex.h"
#include "server/app/part_options.h"
#include "server/app/server.h"
#include "server/app/store_command.h"
#include "server/app/token_command.h"
#include "server/base/memory_reserve.h"
#include "server/base/status.h"
#include "server/config/command_line.h"
#include "server/config/credentials.h"
#include "server/config/log.h"
#include "server/net/service_manager.h"
#include "server/objects/object_store.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

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

/// The transport's threads wake several times for each scan. They are not to interrupt one that is
/// being localized: they inherit this, and the workers do not keep it.
void LetWorkersFinish() {
  const sched_param no_priority{};
  if (sched_setscheduler(0, SCHED_BATCH, &no_priority) != 0) {
    spdlog::warn("transport not scheduled behind the workers");
  }
}

/// glibc would make eight for each processor, between which free memory lies about.
void ShareArenas() {
  mallopt(M_ARENA_MAX, std::max(2, static_cast<int>(std::thread::hardware_concurrency())));
}

/// Debian's absl looks for deadlocks at each mutex that gRPC locks: under a lock of the whole
/// process, with memory that it takes from the system by itself, and does not do without.
void LookForNoDeadlocks() { absl::SetMutexDeadlockDetectionMode(absl::OnDeadlockCycle::kIgnore); }

/// Gives what gRPC cannot do without, once nothing else is left: its threads, and what it reads
/// from connections until their calls are refused.
void KeepMemory() {
  constexpr std::size_t kReserve_bytes = std::size_t{1} << 28;
  if (!MemoryReserve::OfProcess().Keep(kReserve_bytes)) {
    spdlog::warn("no memory is kept in reserve size_mib={}", kReserve_bytes >> 20);
  }
}

/// Threads inherit the mask, so this comes before there are any.
sigset_t BlockSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGHUP);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  // Who reads the log may go; that is no reason to end.
  std::signal(SIGPIPE, SIG_IGN);
  return signals;
}

/// Reads the settings again, from where they came from.
void Reload(int argc, const char* const* argv, Server& server) {
  const absl::StatusOr<CommandLine> command_line = ParseCommandLine(argc, argv);
  absl::Status status = command_line.status();
  if (status.ok()) status = server.Reload(command_line->config);
  if (!status.ok()) spdlog::error("settings not taken reason={}", Quoted(status.message()));
}

/// Gives the signal that ends the program.
int WaitForStop(const sigset_t& signals, int argc, const char* const* argv, Server& server) {
  int signal = 0;
  while (true) {
    sigwait(&signals, &signal);
    if (signal != SIGHUP) return signal;
    Reload(argc, argv, server);
  }
}

int CheckConfig(const ServerConfig& config) {
  absl::Status status = MakeCredentials(config, std::make_shared<CallGate>(0)).status();
  if (status.ok() && !config.map_files.empty()) {
    status = ObjectStore::Open(ObjectOptionsOf(config)).status();
  }
  if (status.ok()) status = TicketsOf(config).status();
  if (!status.ok()) {
    std::cerr << "dcloc-server: " << status.message() << "\n";
    return EXIT_FAILURE;
  }
  std::cout << "the settings are valid\n";
  return EXIT_SUCCESS;
}

int Run(int argc, const char* const* argv, const ServerConfig& config) {
  const sigset_t signals = BlockSignals();
  SetUpLog(config);
  ShareArenas();
  LookForNoDeadlocks();
  KeepMemory();
  RaiseFileLimit();
  LetWorkersFinish();
  const absl::StatusOr<std::unique_ptr<Server>> server = Server::Start(config);
  if (!server.ok()) {
    std::cerr << "dcloc-server: " << server.status().message() << "\n";
    return EXIT_FAILURE;
  }
  if (config.stub_localizer) {
    spdlog::warn("stub localizer: scans are not matched, poses mean nothing");
  }
  // Whoever started the program may wait for this line, and then read the log.
  FlushLog();
  std::cout << "listening on " << (*server)->address() << std::endl;
  NotifyServiceManager("READY=1");

  const int signal = WaitForStop(signals, argc, argv, **server);
  NotifyServiceManager("STOPPING=1");
  spdlog::info("stopping signal={} deadline_ms={}", signal, config.shutdown_deadline_ms);
  (*server)->Shutdown(std::chrono::milliseconds(config.shutdown_deadline_ms));
  spdlog::info("stopped");
  return EXIT_SUCCESS;
}

int Main(int argc, const char* const* argv) {
  // What the program writes is for its own user alone: maps, identities, tokens.
  umask(S_IRWXG | S_IRWXO);
  if (IsTokenCommand(argc, argv)) return RunTokenCommand(argc, argv);
  if (IsStoreCommand(argc, argv)) return RunStoreCommand(argc, argv);
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
  if (command_line->check_config) return CheckConfig(command_line->config);
  const int exit_code = Run(argc, argv, command_line->config);
  FlushLog();
  return exit_code;
}

}  // namespace
}  // namespace dcloc::server

int main(int argc, char** argv) { return dcloc::server::Main(argc, argv); }
