#include "tests/end_to_end/server_process.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <stdexcept>

#include "client/sdk/channel.h"

namespace dcloc {

ServerProcess::ServerProcess(const std::string& program, const std::filesystem::path& store,
                             const std::filesystem::path& log,
                             const ServerProcessOptions& options) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  const int log_file = open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  std::vector<std::string> arguments = {program, "--listen", "127.0.0.1:0", "--data", store};
  if (options.stub_localizer) arguments.emplace_back("--stub-localizer");
  arguments.insert(arguments.end(), options.arguments.begin(), options.arguments.end());
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  pid_ = fork();
  if (pid_ == 0) {
    dup2(ends[1], STDOUT_FILENO);
    dup2(log_file, STDERR_FILENO);
    if (options.max_file_bytes > 0) {
      // Writing on is then an error, as on a full disk, and no signal.
      std::signal(SIGXFSZ, SIG_IGN);
      const rlimit limit{.rlim_cur = options.max_file_bytes, .rlim_max = options.max_file_bytes};
      setrlimit(RLIMIT_FSIZE, &limit);
    }
    execv(program.c_str(), argv.data());
    _exit(127);
  }
  close(ends[1]);
  close(log_file);
  output_ = ends[0];
}

bool ServerProcess::WaitUntilReady() {
  std::string line;
  for (char c = 0; c != '\n'; line += c) {
    if (read(output_, &c, 1) != 1) return false;
  }
  const std::string begin = "listening on ";
  if (line.rfind(begin, 0) != 0) return false;
  address_ = line.substr(begin.size(), line.size() - begin.size() - 1);
  return true;
}

std::shared_ptr<grpc::Channel> ServerProcess::Channel() const {
  return *client::MakeChannel({.server = address_, .own_connection = true});
}

double ServerProcess::ResidentMebibytes() const {
  std::ifstream statm("/proc/" + std::to_string(pid_) + "/statm");
  double total_pages = 0.0;
  double resident_pages = 0.0;
  statm >> total_pages >> resident_pages;
  return resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

double ServerProcess::ProcessorSeconds() const {
  std::ifstream stat("/proc/" + std::to_string(pid_) + "/stat");
  std::string field;
  double ticks = 0.0;
  for (int i = 1; i <= 15 && stat >> field; ++i) {
    if (i >= 14) ticks += std::stod(field);  // utime and stime; the program's name has no space
  }
  return ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
}

void ServerProcess::Kill() {
  if (pid_ >= 0) End(SIGKILL);
}

bool ServerProcess::Terminate() {
  if (pid_ < 0) return false;
  const int status = End(SIGTERM);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

int ServerProcess::End(int signal) {
  int status = 0;
  kill(pid_, signal);
  waitpid(pid_, &status, 0);
  close(output_);
  pid_ = -1;
  return status;
}

}  // namespace dcloc
