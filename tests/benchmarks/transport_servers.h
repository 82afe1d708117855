#pragma once

#include <sys/types.h>

#include <cstddef>
#include <string>

namespace dcloc::benchmarks {

/// A process that serves, on one processor, until this goes. It is this program, called again.
class ServingProcess {
 public:
  /// `kind` is "stub", a server that answers without matching; "echo", which answers each message
  /// with `answer_bytes` bytes from gRPC's own thread; or "hop", the same from the server's worker
  /// pool. Throws std::runtime_error when it does not start.
  ServingProcess(const std::string& kind, std::size_t answer_bytes);
  ~ServingProcess();
  ServingProcess(const ServingProcess&) = delete;
  ServingProcess& operator=(const ServingProcess&) = delete;

  const std::string& address() const { return address_; }

  /// Processor time of all its threads so far [s].
  double cpu_s() const;

 private:
  pid_t pid_ = -1;
  int stdin_fd_ = -1;  ///< it ends when this is closed
  std::string address_;
};

/// What such a process does: prints its address, and serves until standard input ends. The exit
/// status.
int Serve(const std::string& kind, std::size_t answer_bytes);

}  // namespace dcloc::benchmarks
