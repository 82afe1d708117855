#include "client/cli/session/session_propose_command.h"

#include <cmath>
#include <memory>
#include <string>

#include "absl/strings/str_format.h"
#include "client/cli/common/terminal.h"
#include "client/cli/remote/admin_run.h"
#include "client/cli/remote/answer_text.h"
#include "client/cli/remote/server_options.h"
#include "client/cli/remote/wire.h"
#include "client/datasets/fix_file.h"

namespace dcloc::cli {
namespace {

/// A place that somebody points at on a plan has no height.
constexpr double kUnknownHeightSigma_m = 100.0;

struct ProposeArguments {
  client::ChannelOptions server;
  std::string session;
  double x_m = 0.0;
  double y_m = 0.0;
  double yaw_deg = std::nan("");
  double sigma_m = 5.0;
  double yaw_sigma_deg = 10.0;
  bool json = false;
};

v1::PoseWithCovariance PoseFrom(const ProposeArguments& arguments) {
  MapFix fix{.p_map = {arguments.x_m, arguments.y_m, 0.0},
             .horizontal_sigma_m = arguments.sigma_m,
             .vertical_sigma_m = kUnknownHeightSigma_m};
  if (!std::isnan(arguments.yaw_deg)) {
    fix.yaw_deg = arguments.yaw_deg;
    fix.yaw_sigma_deg = arguments.yaw_sigma_deg;
  }
  return ToProto(PoseOf(fix));
}

absl::Status Propose(client::AdminClient& admin, const ProposeArguments& arguments) {
  const absl::StatusOr<v1::Session> session = FindSession(admin, arguments.session);
  if (!session.ok()) return session.status();
  const absl::StatusOr<v1::PositionFixAnswer> answer =
      admin.ProposePose(session->session_id(), PoseFrom(arguments));
  if (!answer.ok()) return answer.status();
  const std::string use = UseText(answer->use());
  if (arguments.json) {
    const nlohmann::ordered_json json = {{"session_id", session->session_id()},
                                         {"vehicle_id", session->vehicle_id()},
                                         {"stamp_ns", answer->stamp_ns()},
                                         {"use", use}};
    absl::PrintF("%s\n", json.dump(2));
  } else {
    absl::PrintF("the pose for %s: %s\n", Visible(session->vehicle_id()), use);
  }
  return absl::OkStatus();
}

}  // namespace

void AddSessionProposeCommand(CLI::App& session_command, int& exit_code) {
  auto arguments = std::make_shared<ProposeArguments>();
  CLI::App* command = AddAdminCommand(session_command, "propose",
                                      "Tell a session where its vehicle was at its last scan",
                                      arguments, exit_code, &Propose);
  command->add_option("session", arguments->session, "Its id, the beginning of it, or its vehicle")
      ->required()
      ->type_name("ID");
  const CLI::Range place(-1e8, 1e8);
  command->add_option("--x", arguments->x_m, "In the map frame")
      ->required()
      ->check(place)
      ->type_name("M");
  command->add_option("--y", arguments->y_m, "In the map frame")
      ->required()
      ->check(place)
      ->type_name("M");
  command
      ->add_option("--yaw-deg", arguments->yaw_deg,
                   "Heading, counter-clockwise from the map's x axis; any without it")
      ->check(CLI::Range(-360.0, 360.0))
      ->type_name("DEG");
  command->add_option("--sigma-m", arguments->sigma_m, "Deviation along each axis")
      ->check(CLI::Range(1e-3, 1e4))
      ->type_name("M")
      ->capture_default_str();
  command->add_option("--yaw-sigma-deg", arguments->yaw_sigma_deg, "Deviation of --yaw-deg")
      ->check(CLI::Range(1e-3, 180.0))
      ->type_name("DEG")
      ->capture_default_str();
  command->footer(
      "The pose is weighed like a position fix of the vehicle's own, and never forces a pose that\n"
      "the radars contradict. It is fused, guides_search, contradicted, or out_of_time.\n"
      "Example:\n  dcloc session propose --server localhost:50051 car-17 --x 120 --y -35 --sigma-m "
      "5");
}

}  // namespace dcloc::cli
