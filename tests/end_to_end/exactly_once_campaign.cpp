#include <CLI/CLI.hpp>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_format.h"
#include "client/sdk/session.h"
#include "tests/end_to_end/disturbed_drive.h"
#include "tests/end_to_end/run_program.h"
#include "tests/end_to_end/session_site.h"
#include "tests/server/fixtures/messages.h"
#include "tests/server/fixtures/test_maps.h"

// As many scans as one likes through a network that breaks and a server that is restarted and
// killed: each scan is answered exactly once, in order, at its own stamp. The stub localizes, so
// that a scan costs what its transport does; session_campaign looks at poses.
namespace dcloc {
namespace {

struct Arguments {
  std::string server;
  int scan_count = 20'000;
  Disturbances disturbances = {
      .cut_count = 20, .restart_count = 2, .restarts = Disturbances::Restarts::kInTurn};
};

constexpr char kVehicle[] = "car-1";
/// Of each so many scans one is to be refused: its radar is unknown.
constexpr int kRefusedEach = 97;

bool IsRefused(int index) { return index % kRefusedEach == kRefusedEach / 2; }

v1::Scan ScanAt(int index) {
  v1::Scan scan = server::ScanMessage(index);
  if (IsRefused(index)) scan.set_radar_id("nobody");
  return scan;
}

class Campaign {
 public:
  explicit Campaign(const Arguments& arguments)
      : arguments_(arguments), site_(arguments.server, kVehicle, SessionSite::Localizer::kStub) {}

  absl::Status Run() {
    if (absl::Status status = site_.Start(server::SmallMap()); !status.ok()) return status;
    const auto session =
        client::Session::Open(site_.Channel(), server::OpenMessage(), CampaignOptions());
    if (!session.ok()) return session.status();
    const DriveScans scans = {.count = arguments_.scan_count,
                              .at = &ScanAt,
                              .take = [this](const v1::LocalizeResponse& answer) { Take(answer); }};
    absl::Status status =
        DriveDisturbed(**session, scans, site_, arguments_.disturbances, recoveries_);
    status.Update(fault_);
    return status;
  }

  void Report() const {
    const client::SessionStats& stats = recoveries_.stats;
    absl::PrintF(
        "%d scans, %d cuts, %d restarts: %d streams broke, %d resumed, %d sessions; each scan was "
        "answered exactly once, in order, at its stamp; %d of them were to be refused, and were. "
        "At most %.2f s from what befell it until the vehicle went on\n",
        arguments_.scan_count, arguments_.disturbances.cut_count,
        arguments_.disturbances.restart_count, stats.disconnect_count, stats.resume_count,
        stats.restart_count + 1, refused_count_, recoveries_.longest.count());
  }

 private:
  /// Answers come in the order of their numbers, which the drive has seen to.
  void Take(const v1::LocalizeResponse& answer) {
    const int index = answered_count_++;
    refused_count_ += answer.has_rejected() ? 1 : 0;
    if (answer.has_rejected() != IsRefused(index)) {
      fault_.Update(
          absl::InternalError(absl::StrFormat("scan %d: %s", index, answer.ShortDebugString())));
    } else if (answer.has_result() && answer.result().stamp_ns() != ScanAt(index).stamp_ns()) {
      fault_.Update(absl::InternalError(absl::StrFormat("scan %d has another one's stamp", index)));
    }
  }

  const Arguments arguments_;
  SessionSite site_;
  Recoveries recoveries_;
  absl::Status fault_;
  int answered_count_ = 0;
  int refused_count_ = 0;
};

int Main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app(
      "Sends scans while connections break and dcloc-server is restarted and killed in turn, and "
      "checks that each is answered exactly once, in order");
  app.add_option("server", arguments.server, "dcloc-server")->required()->check(CLI::ExistingFile);
  app.add_option("--scans", arguments.scan_count)->check(CLI::PositiveNumber);
  app.add_option("--cuts", arguments.disturbances.cut_count, "Of all connections")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--restarts", arguments.disturbances.restart_count,
                 "Of the server, by SIGTERM and SIGKILL in turn")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--seed", arguments.disturbances.seed, "Of the random moments");
  CLI11_PARSE(app, argc, argv);
  Campaign campaign(arguments);
  return RunCampaign(campaign, arguments.disturbances.seed);
}

}  // namespace
}  // namespace dcloc

int main(int argc, char** argv) { return dcloc::RunProgram(&dcloc::Main, argc, argv); }
