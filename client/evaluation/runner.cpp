#include "client/evaluation/runner.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "client/datasets/files/check_range.h"
#include "client/evaluation/cpu_stage_timer.h"

namespace dcloc {
namespace {

std::chrono::nanoseconds Nanoseconds(double seconds) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::duration<double>(seconds));
}

/// Localizes scans of one drive and judges the answers.
class Judge {
 public:
  Judge(const std::shared_ptr<const RadarMap>& map, const Drive& drive,
        const EvaluationOptions& options)
      : map_(map), drive_(drive), options_(options) {
    outcome_.drive = drive.name;
    outcome_.map = map;
  }

  /// A fresh session that will be given the scan `first` first.
  absl::StatusOr<std::unique_ptr<Method>> Start(std::size_t first, std::uint64_t query) const {
    std::optional<InitialPose> initial_pose;
    if (options_.has_initial_pose) {
      initial_pose =
          Perturb(drive_.scans[first].T_map_vehicle, options_.perturbation, drive_.name, query);
    }
    return CreateMethod(options_.method, map_, drive_.rig, initial_pose, options_.localizer);
  }

  /// Localizes one scan; nothing when it is refused, which is counted.
  std::optional<ScanOutcome> Localize(Method& method, const DriveScan& entry) {
    Scan scan = entry.scan;
    if (options_.doppler_ego_velocity) scan.ego_velocity.reset();
    CpuStageTimer timer;
    const auto answer = method.Localize(scan, &timer);
    timer.Stop();
    if (!answer.ok()) {
      if (outcome_.refused_count == 0)
        outcome_.first_refusal = std::string(answer.status().message());
      ++outcome_.refused_count;
      return std::nullopt;
    }
    return ScanOutcome{.radar_id = scan.radar_id,
                       .answer = *answer,
                       .T_map_vehicle_true = entry.T_map_vehicle,
                       .error = ComparePoses(answer->T_map_vehicle, answer->covariance,
                                             answer->observed, entry.T_map_vehicle),
                       .stage_ms = timer.stage_ms(),
                       .total_ms = timer.total_ms()};
  }

  void Keep(ScanOutcome scan) { outcome_.scans.push_back(std::move(scan)); }
  DriveOutcome TakeOutcome() { return std::move(outcome_); }

 private:
  std::shared_ptr<const RadarMap> map_;
  const Drive& drive_;
  const EvaluationOptions& options_;
  DriveOutcome outcome_;
};

absl::Status Track(const Drive& drive, Judge& judge, const std::function<void(double)>& progress) {
  auto method = judge.Start(0, 0);
  if (!method.ok()) return method.status();
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    auto scan = judge.Localize(**method, drive.scans[i]);
    if (scan.has_value()) judge.Keep(*std::move(scan));
    progress(static_cast<double>(i + 1) / static_cast<double>(drive.scans.size()));
  }
  return absl::OkStatus();
}

// The last `count` scans of each radar among the first `end` of the drive, in the drive's order.
std::vector<std::size_t> LastScans(const Drive& drive, std::size_t end, int count) {
  std::vector<std::size_t> indices;
  std::map<std::string, int> counts;
  std::size_t missing = drive.rig.radars.size();
  for (std::size_t i = end; i-- > 0 && missing > 0;) {
    int& taken = counts[drive.scans[i].scan.radar_id];
    if (taken == count) continue;
    indices.push_back(i);
    if (++taken == count) --missing;
  }
  std::ranges::reverse(indices);
  return indices;
}

absl::Status RunQuery(const Drive& drive, std::size_t end, std::uint64_t query,
                      const EvaluationOptions& options, Judge& judge) {
  const auto indices = LastScans(drive, end, options.localizer.scans_per_submap);
  auto method = judge.Start(indices.front(), query);
  if (!method.ok()) return method.status();
  std::optional<ScanOutcome> last;
  for (const std::size_t i : indices) last = judge.Localize(**method, drive.scans[i]);
  if (last.has_value()) judge.Keep(*std::move(last));
  return absl::OkStatus();
}

absl::Status RunPairs(const Drive& drive, const EvaluationOptions& options, Judge& judge,
                      const std::function<void(double)>& progress) {
  const Stamp last = drive.scans.back().scan.stamp;
  const auto interval = Nanoseconds(options.query_interval_s);
  Stamp due = drive.scans.front().scan.stamp + Nanoseconds(options.first_query_s);
  for (std::uint64_t query = 0; due <= last; ++query, due += interval) {
    const auto end = std::ranges::upper_bound(
        drive.scans, due, {}, [](const DriveScan& entry) { return entry.scan.stamp; });
    const auto end_index = static_cast<std::size_t>(end - drive.scans.begin());
    if (absl::Status status = RunQuery(drive, end_index, query, options, judge); !status.ok()) {
      return status;
    }
    progress(static_cast<double>(end_index) / static_cast<double>(drive.scans.size()));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status Validate(const EvaluationOptions& options) {
  absl::Status status = Validate(options.localizer);
  status.Update(Validate(options.perturbation));
  status.Update(CheckRange("query_interval_s", options.query_interval_s, 0.01, 1000.0));
  status.Update(CheckRange("first_query_s", options.first_query_s, 0.0, 1000.0));
  return status;
}

absl::StatusOr<DriveOutcome> Evaluate(const std::shared_ptr<const RadarMap>& map,
                                      const Drive& drive, const EvaluationOptions& options,
                                      const std::function<void(double)>& progress) {
  if (absl::Status status = Validate(options); !status.ok()) return status;
  if (map == nullptr) return absl::InvalidArgumentError("map is null");
  if (drive.scans.empty()) {
    return absl::InvalidArgumentError(absl::StrFormat("drive %s has no scans", drive.name));
  }
  EvaluationOptions judged = options;
  // A query is judged before its prior could be held against other places.
  if (options.protocol == Protocol::kPairs) judged.localizer.verify_prior = false;
  Judge judge(map, drive, judged);
  const absl::Status status = options.protocol == Protocol::kTrack
                                  ? Track(drive, judge, progress)
                                  : RunPairs(drive, options, judge, progress);
  if (!status.ok()) return status;
  return judge.TakeOutcome();
}

}  // namespace dcloc
