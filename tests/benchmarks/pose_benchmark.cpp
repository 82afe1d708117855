// The pose between answers and after them, as a vehicle's control asks for it: its error 100 ms
// after the last answer, how honest its covariance is, and what asking costs.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <functional>
#include <optional>
#include <vector>

#include "client/cli/remote/wire.h"
#include "client/datasets/drive_map.h"
#include "client/evaluation/metrics.h"
#include "client/sdk/pose/pose_tracker.h"
#include "client/simulation/simulation.h"
#include "core/geometry/covariance.h"
#include "core/geometry/degrees.h"
#include "core/localizer/localizer.h"
#include "tests/benchmarks/inputs.h"
#include "tests/benchmarks/ticked_drive.h"

namespace dcloc::benchmarks {
namespace {

using client::PoseEstimate;
using client::PoseTracker;

/// What a vehicle has of its own motion when it asks.
enum class Wheels {
  kUntilNow,     ///< at 50 Hz, up to the moment that it asks for
  kUntilAnswer,  ///< at 50 Hz, up to the answer's stamp: the pose is foretold
  kOfScans,      ///< what goes along with scans
  kNone,
};

/// What a scan says of the motion since the one before.
enum class Bus {
  kVelocity,  ///< a velocity at each scan
  kTicks,     ///< and ticks at 50 Hz, as `Session::AddMotion` sends them
};

/// Simulated drives, each through a town of its own that was mapped at 20 m/s.
struct Drives {
  Bus bus = Bus::kTicks;
  bool stops = false;  ///< halts at crossroads
  int radar_count = 1;
  double length_m = 0.0;
  double speed_mps = 0.0;
  std::uint64_t first_seed = 1;
  int count = 1;
};

/// A drive with the server's answers to it.
struct AnsweredDrive {
  Rig rig;
  std::vector<v1::LocalizationResult> answers;
  std::vector<Pose3> T_map_vehicle;                    ///< true, at the scans
  std::vector<std::optional<EgoVelocity>> velocities;  ///< of the scans
  std::vector<VehicleSignal> signals;
};

struct Errors {
  std::vector<double> position_m, heading_deg, nees;
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();  ///< of (along, across, heading) by variances
  Eigen::Vector3d motion = Eigen::Vector3d::Zero();   ///< squares of the motion's own error
  Eigen::Vector3d variances = Eigen::Vector3d::Zero();  ///< that were added for it
};

std::int64_t Nanoseconds(Stamp stamp) { return stamp.time_since_epoch().count(); }

Pose3 ToPose3(const client::RigidPose& T) {
  const auto& [w, x, y, z] = T.rotation_wxyz;
  return {Eigen::Vector3d(T.translation_m.data()), Eigen::Quaterniond(w, x, y, z)};
}

/// The `index`-th of `drives`.
AnsweredDrive Localized(const Drives& drives, int index) {
  SimulationOptions options;
  options.length_m = drives.length_m;
  options.rig_size = drives.radar_count;
  options.seed = drives.first_seed + static_cast<std::uint64_t>(index);
  options.live_speeds_mps = {drives.speed_mps};
  options.stops = drives.stops;
  const auto passes = Passes(options);
  const simulation::World world = MakeWorld(options);
  const SimulatedPass map_pass = SimulatePassWithTruth(world, options, passes[0]).value();
  SimulatedPass live = SimulatePassWithTruth(world, options, passes[1]).value();
  if (drives.bus == Bus::kTicks) {
    constexpr double kAll_hz = 1e9;
    live.drive = TickedDrive(live, kAll_hz, /*signals_a_tick=*/1);
  }
  const auto map = RadarMap::FromBytes(BuildMap(map_pass.drive, {.name = "town"}).value()).value();
  Vector6d sigmas;
  sigmas << 0.7, 0.7, 0.1, 0.01, 0.01, 0.035;
  auto localizer = Localizer::Create(map, live.drive.rig,
                                     InitialPose{live.drive.scans.front().T_map_vehicle,
                                                 sigmas.cwiseAbs2().asDiagonal()})
                       .value();
  AnsweredDrive answered{live.drive.rig, {}, {}, {}, std::move(live.signals)};
  for (const DriveScan& entry : live.drive.scans) {
    const auto answer = localizer.Localize(entry.scan);
    if (!answer.ok()) continue;
    answered.answers.push_back(cli::ToProto(*answer, live.drive.rig, 0));
    answered.T_map_vehicle.push_back(entry.T_map_vehicle);
    answered.velocities.push_back(entry.scan.ego_velocity);
  }
  return answered;
}

v1::EgoVelocity OfWheels(const VehicleSignal& signal) {
  v1::EgoVelocity velocity;
  velocity.mutable_linear_mps()->set_x(signal.speed_mps);
  velocity.mutable_angular_radps()->set_z(signal.yaw_rate_radps);
  return velocity;
}

/// Of (x, y, yaw) in the pose's own frame, as its errors are.
Eigen::Matrix3d CovarianceOf(const PoseEstimate& estimate) {
  const Matrix6d fixed_axes =
      Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(estimate.covariance.data());
  return FlattenCovariance(TangentFromFixedAxes(ToPose3(estimate.T_map_vehicle), fixed_axes));
}

void Judge(const PoseEstimate& estimate, const Pose3& truth, Errors& errors) {
  const Eigen::Vector3d error = Log(Flatten(ToPose3(estimate.T_map_vehicle).Inverse() * truth));
  const Eigen::Matrix3d covariance = CovarianceOf(estimate);
  errors.position_m.push_back(error.head<2>().norm());
  errors.heading_deg.push_back(std::abs(error.z()) * kDegPerRad);
  errors.nees.push_back(error.dot(covariance.ldlt().solve(error)) / 3.0);
  errors.squares += error.cwiseAbs2().cwiseQuotient(covariance.diagonal());
}

/// The motion from the answer to the moment asked for, alone, and what its covariance adds.
void JudgeMotion(const PoseEstimate& begin, const PoseEstimate& end, const Pose3& T_true,
                 Errors& errors) {
  const Pose3 T = ToPose3(begin.T_map_vehicle).Inverse() * ToPose3(end.T_map_vehicle);
  errors.motion += Log(Flatten(T.Inverse() * T_true)).cwiseAbs2();
  const Pose2 back = Flatten(T).Inverse();
  const Eigen::Matrix3d carried = Adjoint(back) * CovarianceOf(begin) * Adjoint(back).transpose();
  errors.variances += (CovarianceOf(end) - carried).diagonal();
}

/// Each answer is followed by a pause in which the vehicle asks for its pose, at the first moment
/// of its bus that is 100 ms later: then the truth is known. Answers within the pause are left out.
void AskAhead(const AnsweredDrive& drive, Wheels wheels, std::chrono::milliseconds ahead,
              Errors& errors) {
  PoseTracker poses({});
  std::size_t next = 0;  // signal
  Stamp asked{};
  const auto give_until = [&](Stamp stamp) {
    for (; next < drive.signals.size() && drive.signals[next].stamp <= stamp; ++next) {
      const VehicleSignal& signal = drive.signals[next];
      static_cast<void>(poses.AddVelocity(Nanoseconds(signal.stamp), OfWheels(signal)));
    }
  };
  const bool has_bus = wheels == Wheels::kUntilNow || wheels == Wheels::kUntilAnswer;
  for (std::size_t i = 0; i < drive.answers.size(); ++i) {
    const v1::LocalizationResult& answer = drive.answers[i];
    const Stamp stamp{std::chrono::nanoseconds(answer.stamp_ns())};
    if (stamp < asked) continue;
    if (has_bus) give_until(stamp);
    if (wheels == Wheels::kOfScans && drive.velocities[i]) {
      v1::EgoVelocity velocity;
      velocity.mutable_linear_mps()->set_x(drive.velocities[i]->linear_mps.x());
      velocity.mutable_angular_radps()->set_z(drive.velocities[i]->angular_radps.z());
      static_cast<void>(poses.AddVelocity(answer.stamp_ns(), velocity));
    }
    poses.AddAnswer(answer);
    const auto signal = std::ranges::lower_bound(drive.signals, stamp + ahead, std::ranges::less(),
                                                 &VehicleSignal::stamp);
    if (signal == drive.signals.end()) break;
    asked = signal->stamp;
    if (wheels == Wheels::kUntilNow) give_until(asked);
    if (stamp < drive.signals.front().stamp + std::chrono::seconds(2)) continue;  // it settles
    const auto estimate = poses.PoseAt(Nanoseconds(asked));
    if (!estimate.ok() || estimate->state != v1::LOCALIZATION_STATE_TRACKING) continue;
    Judge(*estimate, signal->T_map_vehicle, errors);
    const auto begin = poses.PoseAt(answer.stamp_ns());
    if (ahead.count() == 0 || !begin.ok()) continue;
    JudgeMotion(*begin, *estimate, drive.T_map_vehicle[i].Inverse() * signal->T_map_vehicle,
                errors);
  }
}

/// Errors, ANEES as a whole and of each part, and of the motion since the answer.
void PrintErrors(const char* name, const std::vector<AnsweredDrive>& drives, Wheels wheels,
                 std::chrono::milliseconds ahead = std::chrono::milliseconds(100)) {
  Errors errors;
  for (const AnsweredDrive& drive : drives) AskAhead(drive, wheels, ahead, errors);
  double sum = 0.0;
  for (const double nees : errors.nees) sum += nees;
  const auto count = static_cast<double>(errors.nees.size());
  const Eigen::Vector3d squares = errors.squares / count;
  std::printf("%-44s %7zu %7.3f %7.3f %7.3f %7.3f %6.2f  %5.2f %5.2f %5.2f", name,
              errors.nees.size(), Quantile(errors.position_m, 0.5),
              Quantile(errors.position_m, 0.95), Quantile(errors.position_m, 1.0),
              Quantile(errors.heading_deg, 0.5), sum / count, squares.x(), squares.y(),
              squares.z());
  const Eigen::Vector3d motion = (errors.motion / count).cwiseSqrt();
  const Eigen::Vector3d sigmas = (errors.variances / count).cwiseSqrt();
  if (ahead.count() > 0) {
    std::printf("  %5.1f/%4.1f %5.1f/%4.1f %5.2f/%4.2f", 1e3 * motion.x(), 1e3 * sigmas.x(),
                1e3 * motion.y(), 1e3 * sigmas.y(), 1e3 * motion.z(), 1e3 * sigmas.z());
  }
  std::printf("\n");
}

double CpuNanoseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e9 * static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec);
}

/// Medians over batches, since a clock is slower than what is measured.
void PrintCosts(const AnsweredDrive& drive, int batch_count) {
  PoseTracker poses({});
  constexpr std::size_t kAnswers = 60;
  const std::int64_t end_ns = drive.answers[kAnswers - 1].stamp_ns();
  for (std::size_t i = 0; i < kAnswers; ++i) poses.AddAnswer(drive.answers[i]);
  for (const VehicleSignal& signal : drive.signals) {
    if (Nanoseconds(signal.stamp) > end_ns) break;
    static_cast<void>(poses.AddVelocity(Nanoseconds(signal.stamp), OfWheels(signal)));
  }
  constexpr int kBatch = 1000;
  double sum = 0.0;  // keeps what is measured
  const auto median_ns = [&](const std::function<void(int)>& call) {
    std::vector<double> times_ns;
    for (int batch = 0; batch < batch_count; ++batch) {
      const double begin_ns = CpuNanoseconds();
      for (int i = 0; i < kBatch; ++i) call(i);
      times_ns.push_back((CpuNanoseconds() - begin_ns) / kBatch);
    }
    return Quantile(times_ns, 0.5);
  };
  const auto stamp_ns = [&](int i) { return end_ns + std::int64_t{i % 400 - 300} * 1'000'000; };
  const double pose_ns =
      median_ns([&](int i) { sum += poses.PoseAt(stamp_ns(i))->T_map_vehicle.translation_m[0]; });
  const double smooth_ns = median_ns(
      [&](int i) { sum += poses.SmoothPoseAt(stamp_ns(i))->T_map_vehicle.translation_m[0]; });
  const double answer_ns = median_ns([&](int) { poses.AddAnswer(drive.answers[kAnswers - 1]); });
  std::printf("\nPoseAt %.0f ns, SmoothPoseAt %.0f ns, taking an answer %.0f ns%s\n", pose_ns,
              smooth_ns, answer_ns, std::isfinite(sum) ? "" : " (not finite)");
}

void PrintTable(const Drives& drives) {
  // Wheels are wrong by a factor that is drawn once a drive.
  std::vector<AnsweredDrive> answered;
  for (int i = 0; i < drives.count; ++i) answered.push_back(Localized(drives, i));
  std::printf("\n%d drives of %.0f m at %.0f m/s%s, seeds from %d, radars: %d, scans with %s\n",
              drives.count, drives.length_m, drives.speed_mps, drives.stops ? " with halts" : "",
              static_cast<int>(drives.first_seed), drives.radar_count,
              drives.bus == Bus::kTicks ? "ticks" : "a velocity");
  std::printf("%-44s %7s %23s %7s %6s  %17s  %s\n", "100 ms after the last answer", "asked",
              "p50, p95, max m", "p50 deg", "ANEES", "along across head.",
              "the motion's error / sigma, mm mm mrad");
  PrintErrors("  0 ms after it", answered, Wheels::kUntilNow, std::chrono::milliseconds(0));
  PrintErrors("  wheels at 50 Hz until the moment asked for", answered, Wheels::kUntilNow);
  PrintErrors("  wheels at 50 Hz until the answer", answered, Wheels::kUntilAnswer);
  PrintErrors("  the velocity that went with the scans", answered, Wheels::kOfScans);
  PrintErrors("  answers alone", answered, Wheels::kNone);
}

}  // namespace
}  // namespace dcloc::benchmarks

int main(int argc, char** argv) {
  using namespace dcloc::benchmarks;  // NOLINT(google-build-using-namespace)
  const bool smoke = IsSmokeRun(argc, argv);
  // Of these seeds nothing was chosen.
  const std::vector<Drives> all = {
      {.length_m = 1000.0, .speed_mps = 20.0, .first_seed = 501, .count = 6},
      {.stops = true, .length_m = 1000.0, .speed_mps = 20.0, .first_seed = 511, .count = 4},
      {.length_m = 2000.0, .speed_mps = 40.0 / 3.6, .first_seed = 521, .count = 4},
      {.bus = Bus::kVelocity, .length_m = 1000.0, .speed_mps = 20.0, .first_seed = 501, .count = 6},
      {.bus = Bus::kVelocity,
       .length_m = 2000.0,
       .speed_mps = 40.0 / 3.6,
       .first_seed = 521,
       .count = 4},
      {.radar_count = 5, .length_m = 1000.0, .speed_mps = 20.0, .first_seed = 501, .count = 4}};
  if (smoke) {
    PrintTable({.length_m = 100.0, .speed_mps = 20.0, .first_seed = 1, .count = 1});
    return 0;
  }
  for (const Drives& drives : all) PrintTable(drives);
  PrintCosts(Localized(all.front(), 0), 101);
}
