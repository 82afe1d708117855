#include <arpa/inet.h>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/base/files.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/test_maps.h"
#include "tests/server/fixtures/test_server.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

/// The dcloc-server program as a process of its own, its two outputs in one pipe.
class ServerProcess {
 public:
  /// With a limit of open files where that is not 0.
  explicit ServerProcess(std::vector<std::string> arguments, rlim_t max_file_count = 0) {
    int ends[2];
    if (pipe(ends) != 0) throw std::runtime_error("pipe");
    pid_ = fork();
    if (pid_ == 0) {
      dup2(ends[1], STDOUT_FILENO);
      dup2(ends[1], STDERR_FILENO);
      close(ends[0]);
      const rlimit limit{.rlim_cur = max_file_count, .rlim_max = max_file_count};
      if (max_file_count > 0) setrlimit(RLIMIT_NOFILE, &limit);
      arguments.insert(arguments.begin(), DCLOC_SERVER_PROGRAM);
      std::vector<char*> argv;
      argv.reserve(arguments.size() + 1);
      for (std::string& argument : arguments) argv.push_back(argument.data());
      argv.push_back(nullptr);
      execv(argv[0], argv.data());
      _exit(127);
    }
    close(ends[1]);
    output_ = fdopen(ends[0], "r");
  }
  ServerProcess(const ServerProcess&) = delete;
  ServerProcess& operator=(const ServerProcess&) = delete;

  ~ServerProcess() {
    if (!ended_) {
      kill(pid_, SIGKILL);
      Wait();
    }
    if (output_ != nullptr) std::fclose(output_);
  }

  /// The next line with `part` in it; all that came before if there is none.
  std::string ReadUntil(const std::string& part) {
    std::string all;
    std::string line;
    for (int c = std::fgetc(output_); c != EOF; c = std::fgetc(output_)) {
      line.push_back(static_cast<char>(c));
      if (c != '\n') continue;
      if (line.find(part) != std::string::npos) return line;
      all += line;
      line.clear();
    }
    return all + line;
  }

  /// HOST:PORT of its loopback address, once it listens.
  std::string WaitForAddress() {
    const std::string line = ReadUntil("listening on 127.0.0.1:");
    const std::size_t begin = line.find("127.");
    return begin == std::string::npos ? "" : line.substr(begin, line.find('\n') - begin);
  }

  /// From now on what it says fills a pipe of a page, which nobody reads.
  void StopReading() { fcntl(fileno(output_), F_SETPIPE_SZ, 4096); }

  /// From now on who writes to the pipe is told that nobody is there.
  void CloseOutput() { std::fclose(std::exchange(output_, nullptr)); }

  void Signal(int signal) { kill(pid_, signal); }

  /// It gets no more address space than it has.
  void TakeMemory() {
    std::size_t pages = 0;
    std::ifstream(absl::StrCat("/proc/", pid_, "/statm")) >> pages;
    const rlimit limit{.rlim_cur = pages * sysconf(_SC_PAGESIZE), .rlim_max = RLIM_INFINITY};
    prlimit(pid_, RLIMIT_AS, &limit, nullptr);
  }

  void GiveMemory() {
    const rlimit limit{.rlim_cur = RLIM_INFINITY, .rlim_max = RLIM_INFINITY};
    prlimit(pid_, RLIMIT_AS, &limit, nullptr);
  }

  /// The exit code, or minus the signal that ended it.
  int Wait() {
    int status = 0;
    waitpid(pid_, &status, 0);
    ended_ = true;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

 private:
  pid_t pid_ = -1;
  FILE* output_ = nullptr;
  bool ended_ = false;
};

class ProcessTest : public ::testing::Test {
 protected:
  std::string Store() const { return folder_.path() / "new" / "store"; }
  std::string WriteConfig(const std::string& text) const {
    return folder_.Write("server.json", std::as_bytes(std::span(text)));
  }
  TemporaryFolder folder_;
};

TEST_F(ProcessTest, StartsOnAnEmptyFolderSaysWhereItListensAndStopsOnASignal) {
  for (const int signal : {SIGTERM, SIGINT}) {
    ServerProcess server({"--data", Store(), "--listen", "127.0.0.1:0"});
    const std::string address = server.WaitForAddress();
    ASSERT_NE(address, "");
    const auto stub =
        v1::AdminService::NewStub(grpc::CreateChannel(address, grpc::InsecureChannelCredentials()));
    Call call;
    v1::GetServerStateResponse response;
    const grpc::Status status = stub->GetServerState(&call, {}, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    EXPECT_FALSE(response.stub_matcher());
    const auto begin = std::chrono::steady_clock::now();
    server.Signal(signal);
    EXPECT_EQ(server.Wait(), 0);
    // An idle connection, whose client sleeps, is not worth the deadline of 5 s.
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(3));
  }
}

/// Large messages of many callers at once, for a second; how often it was out of memory.
int CallAtOnce(const std::string& address) {
  const std::vector<std::byte> bytes = SmallMap("large", 4000);
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(1);
  std::atomic<int> refused_count = 0;
  constexpr int kCallers = 16;
  std::vector<std::jthread> callers;
  callers.reserve(kCallers);
  for (int i = 0; i < kCallers; ++i) {
    callers.emplace_back([&, i] {
      v1::UploadMapHeader header = HeaderOf(bytes);
      header.set_map_name(absl::StrCat("junk-", i));
      header.set_sha256(std::string(64, '0'));
      while (std::chrono::steady_clock::now() < end) {
        grpc::ChannelArguments arguments;
        arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
        const auto stub = v1::MapService::NewStub(
            grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments));
        v1::UploadMapResponse response;
        const grpc::Status status = UploadMap(*stub, header, bytes, &response);
        if (status.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED) ++refused_count;
      }
    });
  }
  callers.clear();
  return refused_count;
}

TEST_F(ProcessTest, WithoutMemoryItRefusesCallsUntilThereIsSome) {
  ServerProcess server({"--data", Store(), "--listen", "127.0.0.1:0", "--stub-localizer"});
  const std::string address = server.WaitForAddress();
  const auto channel = grpc::CreateChannel(address, grpc::InsecureChannelCredentials());
  const auto maps = v1::MapService::NewStub(channel);
  const std::vector<std::byte> bytes = SmallMap();
  v1::UploadMapResponse uploaded;
  ASSERT_TRUE(UploadMap(*maps, HeaderOf(bytes), bytes, &uploaded).ok());
  const auto localization = v1::LocalizationService::NewStub(channel);
  TestSession session(*localization);
  ASSERT_TRUE(session.Open(OpenMessage()) && session.Read());

  server.TakeMemory();
  EXPECT_GT(CallAtOnce(address), 0);
  EXPECT_TRUE(session.Localize(ScanMessage(0))) << "vehicles go on";
  server.GiveMemory();
  EXPECT_TRUE(Eventually([&] { return UploadMap(*maps, HeaderOf(bytes), bytes, &uploaded).ok(); }));
  EXPECT_TRUE(session.Localize(ScanMessage(1)));
  session.CloseSending();
  server.Signal(SIGTERM);
  EXPECT_EQ(server.Wait(), 0);
}

TEST_F(ProcessTest, UsageErrorsAreToldApartFromFailures) {
  ServerProcess usage({"--data", Store(), "--no-such-flag"});
  EXPECT_THAT(usage.ReadUntil("no-such-flag"), HasSubstr("dcloc-server: "));
  EXPECT_EQ(usage.Wait(), 2);
  ServerProcess failure({"--data", Store(), "--listen", "0.0.0.0:0"});
  EXPECT_THAT(failure.ReadUntil("0.0.0.0"), HasSubstr("allow_plaintext_off_loopback"));
  EXPECT_EQ(failure.Wait(), 1);
}

TEST_F(ProcessTest, CheckConfigSaysWhatIsWrongWithoutStarting) {
  ServerProcess good({"--data", Store(), "--check-config"});
  EXPECT_THAT(good.ReadUntil("valid"), HasSubstr("the settings are valid"));
  EXPECT_EQ(good.Wait(), 0);
  EXPECT_FALSE(std::filesystem::exists(Store()));
  ServerProcess unknown({"--config", WriteConfig(R"({"max_sesion_count": 5})"), "--check-config"});
  EXPECT_THAT(unknown.ReadUntil("max_sesion_count"), HasSubstr("unknown"));
  EXPECT_EQ(unknown.Wait(), 2);
  ServerProcess open({"--data", Store(), "--listen", "0.0.0.0:0", "--check-config"});
  EXPECT_THAT(open.ReadUntil("0.0.0.0"), HasSubstr("allow_plaintext_off_loopback"));
  EXPECT_EQ(open.Wait(), 1);
}

TEST_F(ProcessTest, AHangupTakesWhatCanChangeAndSaysWhatCannot) {
  const std::string path =
      WriteConfig(R"({"listen": "127.0.0.1:0", "max_session_count": 5, "worker_count": 1})");
  ServerProcess server({"--data", Store(), "--config", path});
  ASSERT_THAT(server.ReadUntil("listening on"), HasSubstr("listening on"));
  WriteConfig(R"({"listen": "127.0.0.1:0", "max_session_count": 6, "worker_count": 2})");
  server.Signal(SIGHUP);
  EXPECT_THAT(server.ReadUntil("worker_count"), HasSubstr("needs a restart"));
  EXPECT_THAT(server.ReadUntil("max_session_count"), HasSubstr("setting taken"));
  WriteConfig(R"({"max_session_count": 0})");
  server.Signal(SIGHUP);
  EXPECT_THAT(server.ReadUntil("settings not taken"), HasSubstr("max_session_count is 0"));
  WriteConfig(R"({"listen": "127.0.0.1:0", "worker_count": 1, "log_level": "error"})");
  server.Signal(SIGHUP);
  server.Signal(SIGTERM);
  EXPECT_EQ(server.Wait(), 0);
}

TEST_F(ProcessTest, TokensAreMadeListedAndRevokedBesideARunningServer) {
  ServerProcess server({"--data", Store(), "--listen", "127.0.0.1:0"});
  ASSERT_THAT(server.ReadUntil("listening on"), HasSubstr("listening on"));
  ServerProcess create({"token", "create", "--data", Store(), "--name", "ops", "--role", "admin"});
  const std::string token = create.ReadUntil("dcloc_");
  EXPECT_THAT(token, ::testing::StartsWith("dcloc_"));
  EXPECT_EQ(create.Wait(), 0);
  ServerProcess list({"token", "list", "--data", Store()});
  EXPECT_THAT(list.ReadUntil("ops"), ::testing::AllOf(HasSubstr("admin"), HasSubstr("expires")));
  EXPECT_EQ(list.Wait(), 0);
  EXPECT_EQ(ServerProcess({"token", "revoke", "--data", Store(), "--id", "1"}).Wait(), 0);
  EXPECT_EQ(ServerProcess({"token", "revoke", "--data", Store(), "--id", "9"}).Wait(), 1);
  EXPECT_EQ(
      ServerProcess({"token", "create", "--data", Store(), "--name", "x", "--role", "god"}).Wait(),
      2);
}

grpc::Status AskFor(const std::string& address) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  const auto stub = v1::AdminService::NewStub(
      grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments));
  grpc::ClientContext call;
  call.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(5));
  v1::GetServerStateResponse response;
  return stub->GetServerState(&call, {}, &response);
}

/// Whether the server has closed the connection by now.
bool IsClosed(const FileDescriptor& connection) {
  char byte = 0;
  const ssize_t size = recv(connection.get(), &byte, 1, MSG_DONTWAIT | MSG_PEEK);
  return size == 0 || (size < 0 && errno != EAGAIN && errno != EWOULDBLOCK);
}

TEST_F(ProcessTest, ConnectionsBeyondTheFilesAreClosedAndTheServerGoesOn) {
  constexpr rlim_t kMaxFileCount = 128;
  ServerProcess server({"--data", Store(), "--listen", "127.0.0.1:0"}, kMaxFileCount);
  EXPECT_THAT(server.ReadUntil("max_session_count"), HasSubstr("LimitNOFILE"));
  const std::string address = server.WaitForAddress();
  sockaddr_in target{};
  target.sin_family = AF_INET;
  target.sin_port =
      htons(static_cast<std::uint16_t>(std::stoi(address.substr(address.find(':') + 1))));
  inet_pton(AF_INET, "127.0.0.1", &target.sin_addr);
  std::vector<FileDescriptor> connections;
  for (rlim_t i = 0; i < 2 * kMaxFileCount; ++i) {
    connections.emplace_back(socket(AF_INET, SOCK_STREAM, 0));
    ASSERT_EQ(connect(connections.back().get(), reinterpret_cast<const sockaddr*>(&target),
                      sizeof(target)),
              0);
  }
  EXPECT_TRUE(Eventually([&] { return IsClosed(connections.back()); }));
  EXPECT_FALSE(IsClosed(connections.front())) << "those before stay";
  connections.clear();
  EXPECT_TRUE(Eventually([&] { return AskFor(address).ok(); })) << "gRPC's own would never accept";
  server.Signal(SIGTERM);
  EXPECT_EQ(server.Wait(), 0);
}

/// Drives through a whole session, of which each scan is logged.
void LocalizeSome(const std::string& address) {
  const auto channel = grpc::CreateChannel(address, grpc::InsecureChannelCredentials());
  const auto maps = v1::MapService::NewStub(channel);
  const std::vector<std::byte> map = SmallMap();
  v1::UploadMapResponse response;
  ASSERT_TRUE(UploadMap(*maps, HeaderOf(map), map, &response).ok());
  const auto localization = v1::LocalizationService::NewStub(channel);
  TestSession session(*localization);
  ASSERT_TRUE(session.Open(OpenMessage()));
  ASSERT_TRUE(session.Read().has_value());
  for (int i = 0; i < 300; ++i) ASSERT_TRUE(session.Localize(ScanMessage(i)).has_value()) << i;
}

TEST_F(ProcessTest, ALogThatNobodyReadsHoldsUpNobody) {
  ServerProcess server(
      {"--data", Store(), "--listen", "127.0.0.1:0", "--stub-localizer", "--log-level", "debug"});
  const std::string address = server.WaitForAddress();
  server.StopReading();
  LocalizeSome(address);
  server.Signal(SIGTERM);
  EXPECT_EQ(server.Wait(), 0);
}

TEST_F(ProcessTest, ALogThatIsClosedEndsNothing) {
  ServerProcess server(
      {"--data", Store(), "--listen", "127.0.0.1:0", "--stub-localizer", "--log-level", "debug"});
  const std::string address = server.WaitForAddress();
  server.CloseOutput();
  LocalizeSome(address);
  server.Signal(SIGTERM);
  EXPECT_EQ(server.Wait(), 0);
}

TEST_F(ProcessTest, SystemdHearsThatItIsReadyLivesAndStops) {
  const std::string path = folder_.path() / "notify";
  const FileDescriptor systemd(socket(AF_UNIX, SOCK_DGRAM, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::copy(path.begin(), path.end(), address.sun_path);
  ASSERT_EQ(bind(systemd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  const timeval patience{.tv_sec = 20, .tv_usec = 0};
  setsockopt(systemd.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
  const auto hear = [&] {
    char text[64] = {};
    return recv(systemd.get(), text, sizeof(text) - 1, 0) > 0 ? std::string(text) : "nothing";
  };
  setenv("NOTIFY_SOCKET", path.c_str(), 1);
  setenv("WATCHDOG_USEC", "600000", 1);
  ServerProcess server({"--data", Store(), "--listen", "127.0.0.1:0"});
  unsetenv("NOTIFY_SOCKET");
  unsetenv("WATCHDOG_USEC");
  EXPECT_EQ(hear(), "READY=1");
  EXPECT_EQ(hear(), "WATCHDOG=1");
  EXPECT_EQ(hear(), "WATCHDOG=1");
  server.Signal(SIGTERM);
  std::string last;
  while ((last = hear()) == "WATCHDOG=1") {
  }
  EXPECT_EQ(last, "STOPPING=1");
  EXPECT_EQ(server.Wait(), 0);
}

TEST_F(ProcessTest, ATakenAddressIsAnError) {
  const TestServer first;
  ServerProcess second({"--data", Store(), "--listen", first.server->address()});
  EXPECT_THAT(second.ReadUntil("cannot be listened on"), HasSubstr(first.server->address()));
  EXPECT_EQ(second.Wait(), 1);
}

TEST_F(ProcessTest, HelpAndVersionAreAnswers) {
  ServerProcess help({"--help"});
  EXPECT_THAT(help.ReadUntil("Examples:"), HasSubstr("Examples:"));
  EXPECT_EQ(help.Wait(), 0);
  ServerProcess version({"--version"});
  EXPECT_THAT(version.ReadUntil("dcloc-server "), HasSubstr("."));
  EXPECT_EQ(version.Wait(), 0);
}

}  // namespace
}  // namespace dcloc::server
