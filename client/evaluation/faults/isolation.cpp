#include "client/evaluation/faults/isolation.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace dcloc::faults {
namespace {

// Processor time, as others on the machine may make a sound session wait.
void LimitProcessorTime(unsigned int limit_s) {
  const rlimit limit{.rlim_cur = limit_s, .rlim_max = limit_s + 1};
  setrlimit(RLIMIT_CPU, &limit);
}

[[noreturn]] void WorkInChild(const std::function<std::string()>& work, unsigned int limit_s,
                              int pipe_end) {
  LimitProcessorTime(limit_s);
  std::string result;
  try {
    result = work();
  } catch (...) {
    std::raise(SIGABRT);
  }
  for (absl::string_view rest = result; !rest.empty();) {
    const ssize_t count = write(pipe_end, rest.data(), rest.size());
    if (count < 0 && errno != EINTR) _exit(1);
    if (count > 0) rest.remove_prefix(static_cast<std::size_t>(count));
  }
  _exit(0);
}

std::string ReadAll(int pipe_end) {
  std::string text;
  std::array<char, 1 << 16> buffer{};
  for (;;) {
    const ssize_t count = read(pipe_end, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return text;
    text.append(buffer.data(), static_cast<std::size_t>(count));
  }
}

}  // namespace

absl::StatusOr<std::string> RunIsolated(const std::function<std::string()>& work,
                                        unsigned int limit_s) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) return absl::InternalError("cannot make a pipe");
  const pid_t child = fork();
  if (child < 0) {
    close(ends[0]);
    close(ends[1]);
    return absl::InternalError("cannot make a process");
  }
  if (child == 0) WorkInChild(work, limit_s, ends[1]);
  close(ends[1]);
  std::string result = ReadAll(ends[0]);
  close(ends[0]);
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return absl::InternalError("cannot wait for the process");
  }
  if (WIFSIGNALED(status)) {
    return absl::AbortedError(absl::StrCat("ended by signal ", WTERMSIG(status)));
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    return absl::AbortedError(absl::StrCat("ended with status ", status));
  }
  return result;
}

}  // namespace dcloc::faults
