#include <CLI/CLI.hpp>
#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/sdk/map_client.h"
#include "client/sdk/session.h"
#include "tests/core/map/synthetic_map.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/end_to_end/server_process.h"

// Swaps the active map under vehicles that come and go, and checks that none is lost, that each
// gets the version that was active, and that the server's memory is what it was before.
namespace dcloc {
namespace {

using namespace std::chrono_literals;

struct Arguments {
  std::string server;
  int swap_count = 10;
  int vehicle_count = 8;
};

constexpr int kWarmUpSwaps = 10;
constexpr double kMaxGrowth = 0.10;

v1::OpenSession OpenMessage(int vehicle) {
  v1::OpenSession open;
  open.set_vehicle_id(absl::StrCat("car-", vehicle));
  open.set_map_name("town");
  v1::RadarModel& radar = *open.mutable_rig()->add_radars();
  radar.set_radar_id("front");
  radar.mutable_t_vehicle_radar()->mutable_translation_m();
  radar.mutable_t_vehicle_radar()->mutable_rotation()->set_w(1.0);
  v1::PoseWithCovariance& pose = *open.mutable_initial_pose();
  pose.mutable_pose()->mutable_translation_m()->set_x(500'200.0);
  pose.mutable_pose()->mutable_translation_m()->set_y(5'400'000.0);
  pose.mutable_pose()->mutable_rotation()->set_w(1.0);
  for (int i = 0; i < 36; ++i) pose.add_covariance(i % 7 == 0 ? 0.01 : 0.0);
  return open;
}

/// Of a vehicle that drives ahead at 10 m/s.
v1::Scan ScanMessage(std::int64_t number) {
  v1::Scan scan;
  scan.set_sequence_number(number);
  scan.set_radar_id("front");
  scan.set_stamp_ns(1'700'000'000'000'000'000 + number * 77'000'000);
  for (int i = 0; i < 40; ++i) {
    const float azimuth_rad = -0.6F + 0.03F * static_cast<float>(i);
    scan.add_range_m(5.0F + static_cast<float>(i % 30));
    scan.add_range_rate_mps(-10.0F * std::cos(azimuth_rad));
    scan.add_azimuth_rad(azimuth_rad);
  }
  scan.mutable_ego_velocity()->mutable_linear_mps()->set_x(10.0);
  scan.mutable_ego_velocity()->mutable_angular_radps();
  return scan;
}

/// Vehicles that open a session, drive a little, and come again.
class Fleet {
 public:
  Fleet(const ServerProcess& server, int vehicle_count) : server_(server) {
    for (int i = 0; i < vehicle_count; ++i) {
      threads_.emplace_back([this, i](const std::stop_token& stop) { Drive(i, stop); });
    }
  }

  std::int64_t session_count() const { return session_count_; }
  std::int64_t answer_count() const { return answer_count_; }
  std::int64_t lost_count() const { return lost_count_; }

  /// Waits until each vehicle has had a new session.
  void WaitForNewSessions() const {
    const std::int64_t goal = session_count_ + 2 * static_cast<std::int64_t>(threads_.size());
    while (session_count_ < goal && lost_count_ == 0) std::this_thread::sleep_for(5ms);
  }

 private:
  void Drive(int vehicle, const std::stop_token& stop) {
    const auto channel = server_.Channel();
    while (!stop.stop_requested()) {
      const bool whole = DriveOnce(channel, vehicle);
      ++session_count_;
      if (!whole) ++lost_count_;
    }
  }

  bool DriveOnce(const std::shared_ptr<grpc::Channel>& channel, int vehicle) {
    constexpr int kScans = 8;
    const auto session =
        client::Session::Open(channel, OpenMessage(vehicle), {.reconnect = std::nullopt});
    if (!session.ok()) return false;
    const std::int64_t version = (*session)->opened().map_version();
    for (int i = 0; i < kScans; ++i) {
      if (!(*session)->Send(ScanMessage(i)).ok()) return false;
      const auto answer = (*session)->Next();
      if (!answer || answer->result().map_version() != version) return false;
      ++answer_count_;
      std::this_thread::sleep_for(2ms);
    }
    (*session)->CloseSending();
    while ((*session)->Next()) {
    }
    return (*session)->EndStatus().ok();
  }

  const ServerProcess& server_;
  std::atomic<std::int64_t> session_count_ = 0;
  std::atomic<std::int64_t> answer_count_ = 0;
  std::atomic<std::int64_t> lost_count_ = 0;
  std::vector<std::jthread> threads_;  ///< last: they use the others
};

class Campaign {
 public:
  explicit Campaign(const Arguments& arguments)
      : arguments_(arguments),
        server_(arguments.server, folder_.path() / "store", folder_.path() / "log") {}

  absl::Status Run() {
    if (!server_.WaitUntilReady()) return absl::InternalError("the server did not start");
    // Until buffers and threads that come with use are there.
    if (absl::Status status = SwapUnderWay(kWarmUpSwaps); !status.ok()) return status;
    const double before_mib = IdleMebibytes();
    if (absl::Status status = SwapUnderWay(arguments_.swap_count); !status.ok()) return status;
    const double after_mib = IdleMebibytes();
    absl::PrintF("%d swaps: %d sessions, %d answers, none lost; memory %.1f MiB, then %.1f MiB\n",
                 arguments_.swap_count, session_count_, answer_count_, before_mib, after_mib);
    if (after_mib <= (1.0 + kMaxGrowth) * before_mib) return absl::OkStatus();
    return absl::InternalError("memory is not back within 10 %");
  }

 private:
  /// Swaps while vehicles come and go.
  absl::Status SwapUnderWay(int swap_count) {
    client::MapClient maps(server_.Channel());
    if (absl::Status status = Swap(maps); !status.ok()) return status;
    const Fleet fleet(server_, arguments_.vehicle_count);
    for (int swap = 1; swap <= swap_count; ++swap) {
      absl::Status status = Swap(maps);
      if (status.ok()) fleet.WaitForNewSessions();
      if (status.ok()) status = CheckVersionOfNewSession();
      if (!status.ok()) return status;
      if (fleet.lost_count() > 0) return absl::InternalError("a session was lost");
    }
    session_count_ += fleet.session_count();
    answer_count_ += fleet.answer_count();
    return absl::OkStatus();
  }

  /// With all vehicles gone.
  double IdleMebibytes() const {
    std::this_thread::sleep_for(500ms);
    return server_.ResidentMebibytes();
  }

  /// Uploads another version, makes it the active one, and deletes the one before the last.
  absl::Status Swap(client::MapClient& maps) {
    SyntheticMap map(1000, 300);  // 13 MB
    map.name = absl::StrFormat("town-%04d", ++version_);
    map.info.name_size_bytes = static_cast<std::uint32_t>(map.name.size());
    const auto file = folder_.Write("town.dclm", map.Bytes());
    const auto uploaded = maps.Upload(file, "town", /*activate=*/true);
    if (!uploaded.ok()) return uploaded.status();
    if (version_ <= 2) return absl::OkStatus();
    return maps.DeleteVersion("town", version_ - 2);
  }

  absl::Status CheckVersionOfNewSession() {
    const auto session =
        client::Session::Open(server_.Channel(), OpenMessage(1000), {.reconnect = std::nullopt});
    if (!session.ok()) return session.status();
    const std::int64_t version = (*session)->opened().map_version();
    if (version == version_) return absl::OkStatus();
    return absl::InternalError(
        absl::StrFormat("a new session got version %d; %d is active", version, version_));
  }

  const Arguments arguments_;
  const TemporaryFolder folder_;
  ServerProcess server_;
  std::int64_t version_ = 0;
  std::int64_t session_count_ = 0;
  std::int64_t answer_count_ = 0;
};

int Main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Swaps a map of dcloc-server under vehicles that come and go");
  app.add_option("server", arguments.server, "dcloc-server")->required()->check(CLI::ExistingFile);
  app.add_option("--swaps", arguments.swap_count, "How often")->check(CLI::PositiveNumber);
  app.add_option("--vehicles", arguments.vehicle_count, "At once")->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = Campaign(arguments).Run();
  if (status.ok()) return EXIT_SUCCESS;
  absl::FPrintF(stderr, "%s\n", status.message());
  return EXIT_FAILURE;
}

}  // namespace
}  // namespace dcloc

int main(int argc, char** argv) { return dcloc::Main(argc, argv); }
