// What a scan costs the server beside the method: the same messages to a bare gRPC echo, to
// dcloc-server with its stub and to dcloc-server with the method, in turn, on one processor.
#include <grpcpp/client_context.h>
#include <grpcpp/generic/generic_stub.h>
#include <sched.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "client/load/latency_histogram.h"
#include "client/sdk/map_client.h"
#include "core/localizer/localizer.h"
#include "server/convert/geometry.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/end_to_end/server_process.h"
#include "tests/server/fixtures/postgres_cluster.h"
#include "tests/server/fixtures/town_drive.h"

namespace dcloc::benchmarks {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kScansPerSecond = 13.4;  // a vehicle

/// Ends the program where something is not as it must be.
void Need(bool good, const char* what) {
  if (good) return;
  std::fprintf(stderr, "transport_benchmark: %s\n", what);
  std::exit(1);
}

double ThreadSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// The calling thread and those that it starts from now on.
void RunOn(int processor) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(processor, &set);
  sched_setaffinity(0, sizeof(set), &set);  // elsewhere the figures are as true, but scatter more
}

grpc::ByteBuffer BytesOf(const v1::LocalizeRequest& request) {
  const grpc::Slice slice(request.SerializeAsString());
  return {&slice, 1};
}

/// What all vehicles send, made once.
struct Messages {
  explicit Messages(const server::TownDrive& town) : open(town.Open()) {
    open.set_resumable(true);  // as the SDK's vehicles are
    for (v1::Scan& scan : town.Scans()) {
      v1::LocalizeRequest request;
      *request.mutable_scan() = std::move(scan);
      poses.push_back(town.live.scans[scans.size()].T_map_vehicle);
      scans.push_back(BytesOf(request));
      mean_bytes += static_cast<double>(scans.back().Length());
    }
    mean_bytes /= static_cast<double>(scans.size());
  }

  /// Of a vehicle that begins with scan `first`.
  v1::LocalizeRequest Open(std::size_t first, int number) const {
    v1::LocalizeRequest request;
    *request.mutable_open() = open;
    request.mutable_open()->set_vehicle_id("car-" + std::to_string(number));
    server::convert::ToProto(poses[first],
                             request.mutable_open()->mutable_initial_pose()->mutable_pose());
    return request;
  }

  v1::OpenSession open;
  std::vector<Pose3> poses;  ///< in the map, true, one for each scan
  std::vector<grpc::ByteBuffer> scans;
  double mean_bytes = 0.0;
};

/// What has come of the scans of all vehicles.
class Answers {
 public:
  void Add(Clock::duration latency) {
    const std::lock_guard lock(mutex_);
    latencies_.Add(latency);
  }

  /// Those since the last time.
  load::LatencyHistogram Take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(latencies_, {});
  }

 private:
  std::mutex mutex_;
  load::LatencyHistogram latencies_;
};

/// One vehicle, on a connection of its own.
class Vehicle final : public grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer> {
 public:
  Vehicle(const ServerProcess& server, const Messages& messages, std::size_t first, int number,
          Answers& answers)
      : messages_(messages), answers_(answers), stub_(server.Channel()), next_(first) {
    message_ = BytesOf(messages.Open(first, number));
    stub_.PrepareBidiStreamingCall(&context_, "/dcloc.v1.LocalizationService/Localize", {}, this);
    AddHold();  // scans are written from outside of reactions
    StartRead(&answer_);
    StartWrite(&message_);
    StartCall();
  }

  /// The next scan, unless the answer before is still to come.
  void Send() {
    if (next_ == messages_.scans.size() || !is_answered_.exchange(false)) return;
    message_ = messages_.scans[next_++];
    sent_ = Clock::now();
    StartWrite(&message_);
  }

  /// Returns once its call has ended.
  void End() {
    context_.TryCancel();
    RemoveHold();
    done_.wait(false);
  }

  void OnReadDone(bool ok) override {
    if (!ok) return;
    if (is_open_) answers_.Add(Clock::now() - sent_);
    is_open_ = true;
    StartRead(&answer_);
    is_answered_ = true;
  }

  void OnDone(const grpc::Status&) override {
    done_ = true;
    done_.notify_one();
  }

 private:
  const Messages& messages_;
  Answers& answers_;
  grpc::GenericStub stub_;
  grpc::ClientContext context_;
  grpc::ByteBuffer message_;
  grpc::ByteBuffer answer_;
  Clock::time_point sent_;
  std::size_t next_;
  bool is_open_ = false;
  std::atomic<bool> is_answered_ = false;
  std::atomic<bool> done_ = false;
};

struct Plan {
  int vehicle_count = 0;
  std::chrono::seconds start{};     ///< until all vehicles track, and what waited is done
  std::chrono::seconds duration{};  ///< measured, after the starts

  /// Scans that a vehicle sends.
  std::size_t scan_count() const {
    return static_cast<std::size_t>(kScansPerSecond *
                                    static_cast<double>((start + duration).count())) +
           1;
  }
  /// Where vehicle `number` begins: they drive everywhere at once.
  std::size_t FirstScan(int number, const Messages& messages) const {
    return static_cast<std::size_t>(number) * (messages.scans.size() - scan_count()) /
           static_cast<std::size_t>(vehicle_count);
  }
};

/// Each vehicle's scan in its turn, at their pace.
void Drive(const std::vector<std::unique_ptr<Vehicle>>& vehicles, Clock::duration duration) {
  const Clock::time_point begin = Clock::now();
  const std::chrono::duration<double> pause(1.0 / kScansPerSecond /
                                            static_cast<double>(vehicles.size()));
  for (std::size_t i = 0; Clock::now() < begin + duration; ++i) {
    std::this_thread::sleep_until(
        begin + std::chrono::duration_cast<Clock::duration>(static_cast<double>(i) * pause));
    vehicles[i % vehicles.size()]->Send();
  }
}

struct Cost {
  double scan_us = 0.0;  ///< of the server's processor
  load::LatencyHistogram latencies;
};

Cost Measure(const ServerProcess& server, const Messages& messages, const Plan& plan) {
  Answers answers;
  std::vector<std::unique_ptr<Vehicle>> vehicles;
  for (int i = 0; i < plan.vehicle_count; ++i) {
    vehicles.push_back(
        std::make_unique<Vehicle>(server, messages, plan.FirstScan(i, messages), i, answers));
  }
  Drive(vehicles, plan.start);
  answers.Take();
  const double begin_s = server.ProcessorSeconds();
  Drive(vehicles, plan.duration);
  Cost cost;
  cost.latencies = answers.Take();
  cost.scan_us =
      1e6 * (server.ProcessorSeconds() - begin_s) / static_cast<double>(cost.latencies.count());
  for (const auto& vehicle : vehicles) vehicle->End();
  return cost;
}

/// What the method alone takes of a processor for a scan, without a server: vehicles in turn.
double LocalizerUs(const server::TownDrive& town, const Messages& messages, const Plan& plan) {
  const absl::StatusOr<std::shared_ptr<const RadarMap>> map = RadarMap::FromBytes(town.map);
  Need(map.ok(), "the map is none");
  LocalizerWorkspace workspace;
  std::vector<Localizer> localizers;
  for (int i = 0; i < plan.vehicle_count; ++i) {
    const Pose3& T_map_vehicle = messages.poses[plan.FirstScan(i, messages)];
    Vector6d variances;
    variances << 1.0, 1.0, 1.0, 0.01, 0.01, 0.01;  // as the messages say
    absl::StatusOr<Localizer> localizer =
        Localizer::Create(*map, town.live.rig, InitialPose{T_map_vehicle, variances.asDiagonal()});
    Need(localizer.ok(), "no localizer");
    localizers.push_back(*std::move(localizer));
  }
  double begin_s = 0.0;
  double count = 0.0;
  for (std::size_t k = 0; k < plan.scan_count(); ++k) {
    if (k == static_cast<std::size_t>(kScansPerSecond * static_cast<double>(plan.start.count()))) {
      begin_s = ThreadSeconds();
      count = 0.0;
    }
    for (int i = 0; i < plan.vehicle_count; ++i) {
      const std::size_t number = plan.FirstScan(i, messages) + k;
      Need(localizers[static_cast<std::size_t>(i)]
               .Localize(town.live.scans[number].scan, workspace)
               .ok(),
           "a scan was refused");
      ++count;
    }
  }
  return 1e6 * (ThreadSeconds() - begin_s) / count;
}

enum class Kind { kEcho, kStub, kMethod, kSharedEngines };

const char* NameOf(Kind kind) {
  switch (kind) {
    case Kind::kEcho:
      return "bare echo";
    case Kind::kStub:
      return "dcloc-server, stub";
    case Kind::kMethod:
      return "dcloc-server";
    case Kind::kSharedEngines:
      return "with PostgreSQL and tickets";
  }
  return "";
}

std::vector<Kind> Kinds() {
  std::vector<Kind> kinds = {Kind::kEcho, Kind::kStub, Kind::kMethod};
  if (server::PostgresCluster::IsInstalled()) kinds.push_back(Kind::kSharedEngines);
  return kinds;
}

std::vector<std::string> ArgumentsOf(Kind kind, const TemporaryFolder& folder) {
  std::vector<std::string> arguments = {"--worker-count", "1"};
  if (kind != Kind::kSharedEngines) return arguments;
  const std::filesystem::path shared = folder.path() / "maps";
  const std::filesystem::path keys = folder.path() / "keys";
  std::filesystem::create_directory(shared);
  std::ofstream(keys) << "first " << std::string(64, 'a') << '\n';
  std::filesystem::permissions(keys, std::filesystem::perms::owner_read);
  const std::string database = server::PostgresCluster::Get().NewDatabase();
  for (const std::string& more : {std::string("--catalogue"), database, std::string("--map-folder"),
                                  shared.string(), std::string("--ticket-keys"), keys.string()}) {
    arguments.push_back(more);
  }
  return arguments;
}

Cost MeasureKind(Kind kind, const std::string& program, const server::TownDrive& town,
                 const Messages& messages, const Plan& plan) {
  const TemporaryFolder folder;
  const std::vector<std::string> arguments = ArgumentsOf(kind, folder);
  RunOn(0);
  ServerProcess server(program, folder.path() / "store", folder.path() / "log",
                       {.stub_localizer = kind == Kind::kStub, .arguments = arguments});
  RunOn(1);
  Need(server.WaitUntilReady(), "a server did not start");
  if (kind != Kind::kEcho) {
    Need(client::MapClient(server.Channel())
             .Upload(folder.Write("town.dclm", town.map), "town", {.activate = true})
             .ok(),
         "the map could not be uploaded");
  }
  return Measure(server, messages, plan);
}

int Main(const std::filesystem::path& server_program, bool smoke) {
  RunOn(1);
  const server::TownDrive town(smoke ? 300.0 : 1000.0);
  const Messages messages(town);
  const std::string echo_program =
      std::filesystem::read_symlink("/proc/self/exe").replace_filename("echo_server");
  std::printf("%.0f bytes a scan, %.1f scans/s a vehicle, the server on one processor\n",
              messages.mean_bytes, kScansPerSecond);
  std::printf("%9s  %-28s %12s %10s %10s %10s %10s\n", "vehicles", "server", "us a scan",
              "over echo", "p50 ms", "p99 ms", "scans/s");
  for (const int vehicle_count : smoke ? std::vector{4} : std::vector{20, 100, 200}) {
    const Plan plan{vehicle_count, std::chrono::seconds(smoke ? 2 : 12),
                    std::chrono::seconds(smoke ? 1 : 15)};
    double echo_us = 0.0;
    std::printf("%9d  %-28s %12.1f\n", vehicle_count, "the method, without a server",
                LocalizerUs(town, messages, plan));
    for (const Kind kind : Kinds()) {
      const Cost cost = MeasureKind(
          kind, kind == Kind::kEcho ? echo_program : server_program.string(), town, messages, plan);
      Need(cost.latencies.count() > 0, "no scan was answered");
      if (kind == Kind::kEcho) echo_us = cost.scan_us;
      std::printf(
          "%9d  %-28s %12.1f %10.1f %10.2f %10.2f %10.0f\n", vehicle_count, NameOf(kind),
          cost.scan_us, cost.scan_us - echo_us, cost.latencies.QuantileMs(0.5),
          cost.latencies.QuantileMs(0.99),
          static_cast<double>(cost.latencies.count()) / static_cast<double>(plan.duration.count()));
      std::fflush(stdout);
    }
  }
  return 0;
}

}  // namespace
}  // namespace dcloc::benchmarks

int main(int argc, char** argv) {
  const bool smoke = argc == 3 && std::string(argv[1]) == "--smoke";
  if (argc != 2 && !smoke) {
    std::fprintf(stderr, "Usage: transport_benchmark [--smoke] DCLOC_SERVER\n");
    return 2;
  }
  return dcloc::benchmarks::Main(argv[argc - 1], smoke);
}
