#include "client/trajectory/trajectory_reader.h"
#include "client/trajectory/trajectory_writer.h"
#include "tests/fuzz/fuzz_target.h"

namespace dcloc {

std::vector<FuzzInput> FuzzSeeds() {
  Trajectory trajectory{.name = "town", .anchor = GeodeticAnchor{}, .poses = {}};
  for (int i = 0; i < 3; ++i) {
    trajectory.poses.push_back({.stamp = Stamp(std::chrono::milliseconds(1'700'000'000'000 + i)),
                                .T_map_vehicle = Pose3()});
    trajectory.poses.back().T_map_vehicle.translation_m.x() = 0.1 * i;
  }
  const std::string tum = *FormatTrajectory(trajectory, TrajectoryFormat::kTum);
  const std::string csv = *FormatTrajectory(trajectory, TrajectoryFormat::kCsv);
  Require(ParseTrajectory(tum, TrajectoryFormat::kTum, "seed")->poses.size() == 3 &&
              ParseTrajectory(csv, TrajectoryFormat::kCsv, "seed")->poses.size() == 3,
          "the seeds are valid");
  return {InputOf(tum), InputOf(csv),
          InputOf("stamp_ns,state,x_m,y_m,z_m,yaw_deg\n1700000000000000000,TRACKING,1,2,3,90\n"
                  "1700000000100000000,INITIALIZING,1,2,3,90\n"),
          InputOf("# comment\n\n1700000000.5 1 2 3 0 0 0 1\r\n")};
}

namespace {

/// What was read can be written, and is then read as it was.
void ReadTwice(absl::string_view text, TrajectoryFormat format) {
  const auto read = ParseTrajectory(text, format, "input");
  if (!read.ok()) return;
  for (std::size_t i = 1; i < read->poses.size(); ++i) {
    Require(read->poses[i - 1].stamp < read->poses[i].stamp, "stamps ascend");
  }
  const auto written = FormatTrajectory(*read, format);
  Require(written.ok(), "what was read can be written");
  const auto again = ParseTrajectory(*written, format, "output");
  Require(again.ok() && again->poses.size() == read->poses.size(), "poses are read as written");
}

}  // namespace
}  // namespace dcloc

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const absl::string_view text(reinterpret_cast<const char*>(data), size);
  dcloc::ReadTwice(text, dcloc::TrajectoryFormat::kTum);
  dcloc::ReadTwice(text, dcloc::TrajectoryFormat::kCsv);
  return 0;
}
