#include "client/cli/localize/localize_run.h"

#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/common/progress.h"
#include "client/cli/common/stop_signals.h"
#include "client/cli/common/terminal.h"
#include "client/cli/localize/answer_files.h"
#include "client/cli/localize/trust_summary.h"
#include "client/cli/remote/learned_rig.h"
#include "client/cli/remote/wire.h"
#include "client/datasets/dataset.h"
#include "client/datasets/fix_file.h"
#include "client/evaluation/metrics_format.h"
#include "client/evaluation/outcome_trajectory.h"
#include "client/sdk/session.h"

namespace dcloc::cli {
namespace {

using Clock = std::chrono::steady_clock;

v1::OpenSession OpenRequest(const LocalizeArguments& arguments, const Drive& drive) {
  v1::OpenSession open;
  open.set_vehicle_id(arguments.vehicle);
  open.set_map_name(arguments.map);
  *open.mutable_rig() = ToProto(drive.rig);
  const InitialPose perturbed =
      Perturb(drive.scans.front().T_map_vehicle, arguments.perturbation, drive.name, 0);
  if (arguments.initial == "truth") *open.mutable_initial_pose() = ToProto(perturbed);
  if (arguments.initial == "gnss") *open.mutable_gnss_fix() = FixOf(perturbed, *arguments.anchor);
  if (arguments.scans_per_submap) {
    open.mutable_options()->set_scans_per_submap(*arguments.scans_per_submap);
  }
  return open;
}

/// Sends a drive's scans, and position fixes among them, on a thread of its own: when their stamps
/// say, or each scan as soon as the one before it is answered.
class Sender {
 public:
  Sender(client::Session& session, const Drive& drive, const std::vector<StampedFix>& fixes,
         const LocalizeArguments& arguments)
      : session_(session),
        drive_(drive),
        fixes_(fixes),
        is_realtime_(arguments.rate == "realtime"),
        sends_ego_velocity_(arguments.ego_velocity == "sensor"),
        sent_at_(drive.scans.size()),
        thread_([this](const std::stop_token& stop) { Run(stop); }) {}

  /// Sends no more; what has been sent is still answered.
  void Stop() {
    thread_.request_stop();
    session_.CloseSending();
  }

  /// The answer to the next scan has come.
  void CountAnswer() {
    {
      const std::lock_guard lock(mutex_);
      ++answered_count_;
    }
    changed_.notify_all();
  }

  /// When scan `index`, which has been answered, was sent.
  Clock::time_point sent_at(std::size_t index) const { return sent_at_[index]; }

 private:
  void Run(const std::stop_token& stop) {
    const Clock::time_point begin = Clock::now();
    for (std::size_t i = 0; i < drive_.scans.size(); ++i) {
      const Scan& scan = drive_.scans[i].scan;
      if (!is_realtime_) WaitForAnswers(i, stop);
      if (!SendFixesUntil(scan.stamp, begin, stop).ok()) return;
      if (is_realtime_) WaitUntil(TimeOf(scan.stamp, begin), stop);
      if (stop.stop_requested()) return;
      v1::Scan message = ToProto(scan, static_cast<std::int64_t>(i));
      if (!sends_ego_velocity_) message.clear_ego_velocity();
      sent_at_[i] = Clock::now();
      // Why it does not take more, the session's end says.
      if (!session_.Send(std::move(message)).ok()) return;
    }
    session_.CloseSending();
  }

  /// When a vehicle that began at `begin` sends what has that stamp.
  Clock::time_point TimeOf(Stamp stamp, Clock::time_point begin) const {
    return begin + (stamp - drive_.scans.front().scan.stamp);
  }

  absl::Status SendFixesUntil(Stamp stamp, Clock::time_point begin, const std::stop_token& stop) {
    for (; next_fix_ < fixes_.size() && fixes_[next_fix_].stamp <= stamp; ++next_fix_) {
      const StampedFix& fix = fixes_[next_fix_];
      if (is_realtime_) WaitUntil(TimeOf(fix.stamp, begin), stop);
      if (stop.stop_requested()) return absl::CancelledError("stopped");
      if (absl::Status status = session_.SendFix(ToProto(fix)); !status.ok()) return status;
    }
    return absl::OkStatus();
  }

  void WaitUntil(Clock::time_point time, const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    changed_.wait_until(lock, stop, time, [] { return false; });
  }

  void WaitForAnswers(std::size_t count, const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, stop, [&] { return answered_count_ >= count; });
  }

  client::Session& session_;
  const Drive& drive_;
  const std::vector<StampedFix>& fixes_;
  const bool is_realtime_;
  const bool sends_ego_velocity_;
  std::vector<Clock::time_point> sent_at_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::size_t answered_count_ = 0;
  std::size_t next_fix_ = 0;
  std::jthread thread_;  ///< last: it uses the others
};

client::SessionOptions SessionOptionsOf(const LocalizeArguments& arguments) {
  client::SessionOptions options{.max_queued_scan_count = 1,
                                 .when_full = client::FullQueue::kBlock};
  options.record_file = arguments.record_file;
  options.reconnect.reset();
  if (arguments.reconnect_s > 0.0) {
    options.reconnect =
        client::ReconnectOptions{.give_up_after = std::chrono::milliseconds(
                                     std::llround(std::ceil(1000.0 * arguments.reconnect_s)))};
  }
  return options;
}

double Milliseconds(std::chrono::nanoseconds duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

// Of the stages that ran; on the wire the others are 0.
void SetStages(const v1::StageTimings& timings, ScanOutcome& outcome) {
  const std::array durations_ns = {timings.compensation_duration_ns(), timings.submap_duration_ns(),
                                   timings.registration_duration_ns(),
                                   timings.posegraph_duration_ns()};
  static_assert(durations_ns.size() == kStageNames.size());
  for (std::size_t i = 0; i < durations_ns.size(); ++i) {
    if (durations_ns[i] > 0) {
      outcome.stage_ms[i] = Milliseconds(std::chrono::nanoseconds(durations_ns[i]));
    }
  }
}

absl::StatusOr<ScanOutcome> Judge(const v1::LocalizationResult& result, const DriveScan& entry) {
  absl::StatusOr<Localization> answer = FromProto(result);
  if (!answer.ok()) return answer.status();
  ScanOutcome outcome{.radar_id = entry.scan.radar_id,
                      .answer = *std::move(answer),
                      .T_map_vehicle_true = entry.T_map_vehicle,
                      .error = {},
                      .stage_ms = {},
                      .total_ms = 0.0};
  outcome.error = ComparePoses(outcome.answer.T_map_vehicle, outcome.answer.covariance,
                               outcome.answer.observed, entry.T_map_vehicle);
  SetStages(result.timings(), outcome);
  return outcome;
}

// Takes the answers until the session has ended.
absl::Status Receive(client::Session& session, Sender& sender, const Drive& drive,
                     AnswerFiles& files, DriveOutcome& outcome, TrustSummary& trust,
                     std::optional<v1::LearnedRig>& learned) {
  Progress progress(absl::StrCat("localizing ", drive.name), drive.scans.size());
  while (const std::optional<v1::LocalizeResponse> response = session.Next()) {
    const Clock::time_point now = Clock::now();
    if (response->has_position_fix_answer()) {
      trust.Add(response->position_fix_answer());
      continue;
    }
    const std::int64_t number = response->has_result() ? response->result().sequence_number()
                                                       : response->rejected().sequence_number();
    const auto index = static_cast<std::size_t>(number);
    if (index >= drive.scans.size()) {
      return absl::DataLossError(
          absl::StrCat("the server answered scan ", number, " of ", drive.scans.size()));
    }
    sender.CountAnswer();
    progress.Update(index + 1);
    if (response->has_rejected()) {
      if (outcome.refused_count++ == 0) outcome.first_refusal = response->rejected().message();
      continue;
    }
    absl::StatusOr<ScanOutcome> scan = Judge(response->result(), drive.scans[index]);
    if (!scan.ok()) return scan.status();
    scan->total_ms = Milliseconds(now - sender.sent_at(index));
    files.Add(response->result(), *scan);
    if (response->result().has_learned_rig()) learned = response->result().learned_rig();
    if (const std::string news = trust.Add(response->result()); !news.empty()) {
      progress.Say(news);
    }
    outcome.scans.push_back(*std::move(scan));
  }
  return session.EndStatus();
}

void PrintConnection(const client::SessionStats& stats) {
  if (stats.disconnect_count == 0) return;
  absl::PrintF(
      "The connection broke %d times: %d times the session went on, %d times it began anew from "
      "the last pose.\n",
      stats.disconnect_count, stats.resume_count, stats.restart_count);
}

/// Errors only where the drive has poses to judge by.
void PrintSummary(const DriveOutcome& outcome, const Drive& drive) {
  const std::size_t scan_count = drive.scans.size();
  const Metrics metrics = ComputeMetrics({&outcome, 1});
  if (drive.pose_source == PoseSource::kReference) {
    absl::PrintF("%s", FormatTable(MetricsRows({{outcome.drive, metrics}})));
  } else {
    absl::PrintF(
        "Tracking, dead reckoning, lost: %d, %d, %d of %d scans. The drive has no reference poses "
        "to judge by.\n",
        metrics.state_counts[1], metrics.state_counts[2], metrics.state_counts[3],
        metrics.scan_count);
  }
  absl::PrintF("%d of %d scans were answered. Total is the round trip as the vehicle sees it.\n",
               outcome.scans.size() + outcome.refused_count, scan_count);
  if (outcome.refused_count > 0) {
    absl::PrintF("%d scans were refused, the first because %s\n", outcome.refused_count,
                 Visible(outcome.first_refusal));
  }
}

/// What `PrintSummary` and `PrintConnection` say, for scripts.
void PrintJson(const DriveOutcome& outcome, const Drive& drive, const client::SessionStats& stats,
               const TrustSummary& trust) {
  nlohmann::ordered_json json = {{"drive", outcome.drive},
                                 {"scan_count", drive.scans.size()},
                                 {"first_refusal", outcome.first_refusal},
                                 {"disconnect_count", stats.disconnect_count},
                                 {"resume_count", stats.resume_count},
                                 {"restart_count", stats.restart_count},
                                 {"lost_fix_count", stats.lost_fix_count}};
  json.update(trust.Json());
  json.update(MetricsJson(ComputeMetrics({&outcome, 1})));
  if (drive.pose_source != PoseSource::kReference) {
    for (const char* judged : {"rte_m", "rre_deg", "success_rate", "success_rate_all", "anees",
                               "coverage_95", "coverage_999", "misleading_count"}) {
      json[judged] = nullptr;
    }
  }
  absl::PrintF("%s\n", json.dump(2));
}

std::optional<GeodeticAnchor> AnchorOf(const v1::SessionOpened& opened) {
  if (!opened.has_anchor()) return std::nullopt;
  return FromProto(opened.anchor());
}

absl::Status Localize(client::Session& session, const Drive& drive,
                      const std::vector<StampedFix>& fixes, const LocalizeArguments& arguments,
                      const StopSignals& signals, AnswerFiles& files) {
  DriveOutcome outcome;
  outcome.drive = drive.name;
  std::atomic<bool> interrupted = false;
  TrustSummary trust;
  Sender sender(session, drive, fixes, arguments);
  // The first signal ends the sending, a second one does not wait for what is under way.
  const std::jthread watcher = signals.Watch([&](int count) {
    interrupted = true;
    sender.Stop();
    if (count > 1) session.Cancel();
  });
  std::optional<v1::LearnedRig> learned;
  absl::Status status = Receive(session, sender, drive, files, outcome, trust, learned);
  sender.Stop();
  session.Cancel();
  if (interrupted) status = absl::CancelledError("interrupted; the files hold what was answered");
  status.Update(files.Close());
  status.Update(
      WriteTrajectory(arguments.trajectory, TrajectoryOf(outcome, AnchorOf(session.opened()))));
  status.Update(session.record_status());
  if (learned && !arguments.learned_rig_file.empty()) {
    status.Update(WriteLearnedRig(arguments.learned_rig_file, *learned));
  }
  if (arguments.json) {
    PrintJson(outcome, drive, session.stats(), trust);
  } else {
    PrintSummary(outcome, drive);
    absl::PrintF("%s", trust.Text());
    if (learned) absl::PrintF("%s", LearnedRigText(*learned));
    PrintConnection(session.stats());
  }
  return status;
}

/// Whether the server and its map can take the fixes.
absl::Status CheckFixes(const std::vector<StampedFix>& fixes, const v1::SessionOpened& opened,
                        const LocalizeArguments& arguments) {
  if (fixes.empty()) return absl::OkStatus();
  if (!opened.takes_position_fixes()) {
    return absl::UnimplementedError(absl::StrCat(
        arguments.server.server, ": the server takes no position fixes; it is an older one"));
  }
  if (std::holds_alternative<GnssFix>(fixes.front().position) && !opened.has_anchor()) {
    return absl::FailedPreconditionError(absl::StrCat(arguments.fix_file,
                                                      ": has positions on the Earth, and map ",
                                                      opened.map_name(), " has no anchor"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status RunLocalize(const LocalizeArguments& arguments) {
  const absl::StatusOr<Drive> drive = ReadDrive(arguments.dataset, arguments.drive);
  if (!drive.ok()) return drive.status();
  if (drive->scans.empty()) {
    return absl::InvalidArgumentError(absl::StrCat("drive ", drive->name, " has no scans"));
  }
  if (arguments.initial != "none") {
    const absl::Status status =
        CheckHasReference(*drive, absl::StrCat("--initial ", arguments.initial));
    if (!status.ok()) {
      return absl::FailedPreconditionError(absl::StrCat(status.message(), "; say --initial none"));
    }
  }
  absl::StatusOr<std::vector<StampedFix>> fixes = std::vector<StampedFix>();
  if (!arguments.fix_file.empty()) fixes = ReadFixes(arguments.fix_file);
  if (!fixes.ok()) return fixes.status();
  absl::StatusOr<std::optional<v1::LearnedRig>> known = std::optional<v1::LearnedRig>();
  if (!arguments.learned_rig_file.empty()) known = ReadLearnedRig(arguments.learned_rig_file);
  if (!known.ok()) return known.status();
  // Before a server is asked for anything; whether its map has an anchor, it will say.
  if (absl::Status status = CheckTrajectory(arguments.trajectory, true); !status.ok()) {
    return status;
  }
  v1::OpenSession open = OpenRequest(arguments, *drive);
  if (*known) *open.mutable_learned_rig() = **known;
  const StopSignals signals;
  const auto channel = client::MakeChannel(arguments.server);
  if (!channel.ok()) return channel.status();
  auto session = client::Session::Open(*channel, std::move(open), SessionOptionsOf(arguments));
  if (!session.ok()) {
    return absl::Status(session.status().code(),
                        absl::StrCat(arguments.server.server, ": ", session.status().message()));
  }
  const v1::SessionOpened& opened = (*session)->opened();
  absl::Status status = CheckFixes(*fixes, opened, arguments);
  status.Update(CheckTrajectory(arguments.trajectory, opened.has_anchor()));
  if (!status.ok()) return status;
  absl::StatusOr<AnswerFiles> files = AnswerFiles::Create(arguments.csv_file, arguments.tum_file);
  if (!files.ok()) return files.status();
  return Localize(**session, *drive, *fixes, arguments, signals, *files);
}

}  // namespace dcloc::cli
