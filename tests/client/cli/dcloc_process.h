#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>

#include "tests/core/map/temporary_folder.h"

namespace dcloc {

/// What a run of `dcloc` came to.
struct Result {
  int exit_code = -1;
  std::string out;
  std::string err;
};

/// `dcloc` under way, with words that the shell splits.
class DclocProcess {
 public:
  explicit DclocProcess(const std::string& arguments) {
    const std::string command = std::string("exec ") + DCLOC_PROGRAM + " " + arguments + " >" +
                                Path("out") + " 2>" + Path("err");
    pid_ = fork();
    if (pid_ == 0) {
      execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
      _exit(127);
    }
  }

  void Signal(int signal) const { kill(pid_, signal); }

  bool HasEnded() {
    int status = 0;
    if (!status_ && waitpid(pid_, &status, WNOHANG) == pid_) status_ = status;
    return status_.has_value();
  }

  /// What it has said by now.
  std::string Err() const { return Text("err"); }
  std::string Out() const { return Text("out"); }

  Result Wait() {
    int status = 0;
    if (!HasEnded() && waitpid(pid_, &status, 0) == pid_) status_ = status;
    const bool exited = status_ && WIFEXITED(*status_);
    return {exited ? WEXITSTATUS(*status_) : -1, Text("out"), Text("err")};
  }

 private:
  std::string Path(const char* name) const { return (folder_.path() / name).string(); }
  std::string Text(const char* name) const {
    std::ifstream file(Path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }

  const TemporaryFolder folder_;
  pid_t pid_ = -1;
  std::optional<int> status_;
};

inline Result Dcloc(const std::string& arguments) { return DclocProcess(arguments).Wait(); }

}  // namespace dcloc
