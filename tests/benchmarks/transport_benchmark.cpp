// What a scan costs the server beside the method: processor time of a message in a server that
// answers without matching, beside a bare echo of as many bytes, in turn and at the same pace.
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "dcloc/v1/localization_service.pb.h"
#include "dcloc/v1/map_service.grpc.pb.h"
#include "tests/benchmarks/transport_servers.h"
#include "tests/end_to_end/run_program.h"
#include "tests/server/fixtures/messages.h"
#include "tests/server/fixtures/test_maps.h"
#include "tests/server/fixtures/test_server.h"

namespace dcloc::benchmarks {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kTargetCount = 55;  // of a scan of an ARS408
constexpr double kRate_hz = 13.4;

struct Plan {
  int vehicle_count = 200;
  int round_count = 5;
  std::chrono::milliseconds slice{4000};  // of one server in a round
};

grpc::ByteBuffer BytesOf(const v1::LocalizeRequest& request) {
  const grpc::Slice slice(request.SerializeAsString());
  return {&slice, 1};
}

grpc::ByteBuffer Opening(int vehicle) {
  v1::LocalizeRequest request;
  *request.mutable_open() = server::OpenMessage();
  request.mutable_open()->set_vehicle_id("car-" + std::to_string(vehicle));
  request.mutable_open()->set_resumable(true);
  return BytesOf(request);
}

grpc::ByteBuffer ScanBytes(std::int64_t number) {
  v1::LocalizeRequest request;
  *request.mutable_scan() = server::ScanMessage(number, kTargetCount);
  return BytesOf(request);
}

std::shared_ptr<grpc::Channel> ChannelTo(const std::string& address) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
}

// A vehicle on a connection of its own, which sends when it is told to.
class Vehicle final : public grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer> {
 public:
  Vehicle(const std::string& address, int number) : stub_(ChannelTo(address)) {
    stub_.PrepareBidiStreamingCall(&context_, "/dcloc.v1.LocalizationService/Localize",
                                   grpc::StubOptions(), this);
    AddHold();
    request_ = Opening(number);
    is_sending_ = true;
    StartWrite(&request_);
    StartRead(&answer_);
    StartCall();
  }

  ~Vehicle() override {
    context_.TryCancel();
    RemoveHold();
    while (!is_done_) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

  // The next scan; left out while the last one is on its way.
  void Send() {
    if (is_done_ || is_sending_.exchange(true)) return;
    request_ = ScanBytes(++number_);
    StartWrite(&request_);
  }

  void OnWriteDone(bool /*ok*/) override { is_sending_ = false; }
  void OnReadDone(bool ok) override {
    if (!ok) return;
    answer_bytes_ = answer_.Length();
    ++answer_count_;
    StartRead(&answer_);
  }
  void OnDone(const grpc::Status& status) override {
    if (status.error_code() != grpc::StatusCode::CANCELLED) {
      std::fprintf(stderr, "a call ended: %s\n", status.error_message().c_str());
    }
    is_done_ = true;
  }

  std::int64_t answer_count() const { return answer_count_; }
  std::size_t answer_bytes() const { return answer_bytes_; }

 private:
  grpc::GenericStub stub_;
  grpc::ClientContext context_;
  grpc::ByteBuffer request_, answer_;
  std::int64_t number_ = 0;
  std::atomic<bool> is_sending_ = false;
  std::atomic<bool> is_done_ = false;
  std::atomic<std::int64_t> answer_count_ = 0;
  std::atomic<std::size_t> answer_bytes_ = 0;
};

// A server with its vehicles, and what was measured of it.
struct Served {
  Served(const std::string& kind, std::size_t answer_bytes)
      : name(kind), process(kind, answer_bytes) {}

  std::int64_t answer_count() const {
    std::int64_t count = 0;
    for (const auto& vehicle : vehicles) count += vehicle->answer_count();
    return count;
  }

  std::string name;
  ServingProcess process;
  std::vector<std::unique_ptr<Vehicle>> vehicles;
  std::vector<double> costs_us;  // of a message, by round
};

template <typename Done>
void WaitUntil(const Done& done, const char* what) {
  const Clock::time_point end = Clock::now() + std::chrono::seconds(60);
  while (!done()) {
    if (Clock::now() > end) throw std::runtime_error(what);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

void Upload(const std::string& address) {
  const std::vector<std::byte> map = server::SmallMap();
  v1::UploadMapResponse response;
  const auto maps = v1::MapService::NewStub(ChannelTo(address));
  const grpc::Status status = server::UploadMap(*maps, server::HeaderOf(map), map, &response);
  if (!status.ok()) throw std::runtime_error(status.error_message());
}

void Enter(Served& served, int count) {
  for (int i = 0; i < count; ++i) {
    served.vehicles.push_back(std::make_unique<Vehicle>(served.process.address(), i));
  }
  WaitUntil([&] { return served.answer_count() >= count; }, "a vehicle has no session");
}

// All vehicles at their rate, evenly spread, for so long.
void Drive(Served& served, std::chrono::milliseconds time) {
  const Clock::time_point begin = Clock::now();
  const double interval_s = 1.0 / (kRate_hz * static_cast<double>(served.vehicles.size()));
  for (std::size_t i = 0;; ++i) {
    const auto due =
        begin + std::chrono::duration_cast<Clock::duration>(
                    std::chrono::duration<double>(interval_s * static_cast<double>(i)));
    if (due > begin + time) return;
    std::this_thread::sleep_until(due);
    served.vehicles[i % served.vehicles.size()]->Send();
  }
}

void Measure(Served& served, const Plan& plan) {
  Drive(served, plan.slice / 4);
  const double begin_s = served.process.cpu_s();
  const std::int64_t begin = served.answer_count();
  Drive(served, plan.slice);
  const auto count = static_cast<double>(served.answer_count() - begin);
  served.costs_us.push_back(1e6 * (served.process.cpu_s() - begin_s) / count);
}

double MedianOf(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

void Print(const Served& served, const Served& echo) {
  std::vector<double> differences;
  for (std::size_t i = 0; i < served.costs_us.size(); ++i) {
    differences.push_back(served.costs_us[i] - echo.costs_us[i]);
  }
  std::printf("%-8s %10.1f %10.1f %16.1f\n", served.name.c_str(),
              *std::ranges::min_element(served.costs_us), MedianOf(served.costs_us),
              MedianOf(differences));
}

int Compare(const Plan& plan) {
  Served stub("stub", 0);
  Upload(stub.process.address());
  Enter(stub, plan.vehicle_count);
  Drive(stub, std::chrono::milliseconds(200));
  WaitUntil([&] { return stub.vehicles.front()->answer_count() >= 2; }, "a scan has no answer");
  const std::size_t answer_bytes = stub.vehicles.front()->answer_bytes();
  Served hop("hop", answer_bytes);
  Enter(hop, plan.vehicle_count);
  Served echo("echo", answer_bytes);
  Enter(echo, plan.vehicle_count);
  for (int round = 0; round < plan.round_count; ++round) {
    for (Served* served : {&echo, &stub, &hop}) Measure(*served, plan);
  }
  std::printf("%d vehicles at %.1f Hz, %zu bytes to the server, %zu back\n", plan.vehicle_count,
              kRate_hz, ScanBytes(1).Length(), answer_bytes);
  std::printf("%-8s %10s %10s %16s\n", "CPU [us]", "least", "median", "above the echo");
  for (const Served* served : {&echo, &hop, &stub}) Print(*served, echo);
  return EXIT_SUCCESS;
}

int Run(int argc, char** argv) {
  const std::vector<std::string_view> words(argv + 1, argv + argc);
  if (words.size() == 3 && words[0] == "--serve") {
    return Serve(argv[2], std::strtoul(argv[3], nullptr, 10));
  }
  if (words.empty()) return Compare({});
  if (words.size() == 1 && words[0] == "--smoke") {
    return Compare({.vehicle_count = 4, .round_count = 1, .slice = std::chrono::milliseconds(400)});
  }
  std::fprintf(stderr, "Usage: %s [--smoke]\n", argv[0]);
  return 2;
}

}  // namespace
}  // namespace dcloc::benchmarks

int main(int argc, char** argv) { return dcloc::RunProgram(&dcloc::benchmarks::Run, argc, argv); }
