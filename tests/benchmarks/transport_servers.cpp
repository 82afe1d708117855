#include "tests/benchmarks/transport_servers.h"

#include <fcntl.h>
#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/grpcpp.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <optional>
#include <stdexcept>

#include "server/app/server.h"
#include "server/base/worker_pool.h"
#include "spdlog/spdlog.h"
#include "tests/core/map/temporary_folder.h"

namespace dcloc::benchmarks {
namespace {

/// Answers each message with the same bytes; on a strand of `pool`, if there is one.
class EchoCall final : public grpc::ServerGenericBidiReactor {
 public:
  EchoCall(const grpc::ByteBuffer& answer, server::WorkerPool* pool) : answer_(answer) {
    if (pool != nullptr) strand_.emplace(*pool);
    StartRead(&request_);
  }

  void OnReadDone(bool ok) override {
    if (!ok) return Finish(grpc::Status::OK);
    if (!strand_) return StartWrite(&answer_);
    strand_->Post([this] { StartWrite(&answer_); });
  }

  void OnWriteDone(bool ok) override {
    if (!ok) return Finish(grpc::Status::CANCELLED);
    StartRead(&request_);
  }

  void OnDone() override { delete this; }

 private:
  grpc::ByteBuffer request_;
  grpc::ByteBuffer answer_;
  std::optional<server::Strand> strand_;
};

class EchoService final : public grpc::CallbackGenericService {
 public:
  EchoService(std::size_t answer_bytes, bool with_hop) {
    const std::string text(answer_bytes, 'a');
    const grpc::Slice slice(text);
    answer_ = grpc::ByteBuffer(&slice, 1);
    if (with_hop) pool_.emplace(1);
  }

  grpc::ServerGenericBidiReactor* CreateReactor(
      grpc::GenericCallbackServerContext* /*context*/) override {
    return new EchoCall(answer_, pool_ ? &*pool_ : nullptr);
  }

 private:
  grpc::ByteBuffer answer_;
  std::optional<server::WorkerPool> pool_;
};

void SayAndWait(const std::string& address) {
  std::printf("%s\n", address.c_str());
  std::fflush(stdout);
  while (std::getchar() != EOF) {
  }
}

int ServeEcho(std::size_t answer_bytes, bool with_hop) {
  EchoService service(answer_bytes, with_hop);
  grpc::ServerBuilder builder;
  int port = 0;
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
  builder.RegisterCallbackGenericService(&service);
  const std::unique_ptr<grpc::Server> server = builder.BuildAndStart();
  if (server == nullptr) return EXIT_FAILURE;
  SayAndWait("127.0.0.1:" + std::to_string(port));
  server->Shutdown(std::chrono::system_clock::now());
  return EXIT_SUCCESS;
}

int ServeStub() {
  spdlog::set_level(spdlog::level::warn);
  const TemporaryFolder folder;
  server::ServerConfig config;
  config.data = folder.path() / "store";
  config.listen = "127.0.0.1:0";
  config.stub_matcher = true;
  const auto server = server::Server::Start(config);
  if (!server.ok()) {
    std::fprintf(stderr, "%s\n", std::string(server.status().message()).c_str());
    return EXIT_FAILURE;
  }
  SayAndWait((*server)->address());
  return EXIT_SUCCESS;
}

/// Both kinds of server share one processor with the other's idle threads alone.
void StayOnOneProcessor() {
  cpu_set_t allowed;
  if (sched_getaffinity(0, sizeof(allowed), &allowed) != 0) return;
  for (int i = CPU_SETSIZE - 1; i >= 0; --i) {
    if (!CPU_ISSET(i, &allowed)) continue;
    CPU_ZERO(&allowed);
    CPU_SET(i, &allowed);
    sched_setaffinity(0, sizeof(allowed), &allowed);
    return;
  }
}

}  // namespace

int Serve(const std::string& kind, std::size_t answer_bytes) {
  StayOnOneProcessor();
  return kind == "stub" ? ServeStub() : ServeEcho(answer_bytes, kind == "hop");
}

ServingProcess::ServingProcess(const std::string& kind, std::size_t answer_bytes) {
  std::array<int, 2> in{};
  std::array<int, 2> out{};
  if (pipe2(in.data(), O_CLOEXEC) != 0 || pipe2(out.data(), O_CLOEXEC) != 0) {
    throw std::runtime_error("no pipe");
  }
  const std::string size = std::to_string(answer_bytes);
  pid_ = vfork();
  if (pid_ == 0) {
    dup2(in[0], STDIN_FILENO);
    dup2(out[1], STDOUT_FILENO);
    execl("/proc/self/exe", "transport_benchmark", "--serve", kind.c_str(), size.c_str(), nullptr);
    _exit(EXIT_FAILURE);
  }
  close(in[0]);
  close(out[1]);
  stdin_fd_ = in[1];
  std::FILE* output = fdopen(out[0], "r");
  std::array<char, 128> line{};
  const bool has_said =
      output != nullptr && std::fgets(line.data(), line.size(), output) != nullptr;
  if (output != nullptr) std::fclose(output);
  if (pid_ < 0 || !has_said) throw std::runtime_error(kind + " did not start");
  address_ = line.data();
  address_.pop_back();
}

ServingProcess::~ServingProcess() {
  close(stdin_fd_);
  waitpid(pid_, nullptr, 0);
}

double ServingProcess::cpu_s() const {
  clockid_t clock{};
  timespec now{};
  if (clock_getcpuclockid(pid_, &clock) != 0 || clock_gettime(clock, &now) != 0) return 0.0;
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace dcloc::benchmarks
