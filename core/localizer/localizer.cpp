#include "core/localizer/localizer.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "absl/strings/str_format.h"
#include "core/localizer/pipeline.h"
#include "core/localizer/radar_clocks.h"
#include "core/localizer/recent_answers.h"
#include "core/localizer/stamp_monitor.h"
#include "core/localizer/time_base.h"
#include "core/radar/scan_fingerprint.h"
#include "core/radar/stamp.h"
#include "core/registration/gicp_registration.h"

namespace dcloc {
namespace {

template <int Dim>
std::unique_ptr<AnyPipeline> MakePipeline(std::shared_ptr<const RadarMap> map, Rig rig,
                                          const std::optional<InitialPose>& initial_pose,
                                          const LocalizerOptions& options,
                                          const RegistrationMethods& methods) {
  std::shared_ptr<const RegistrationMethod<Dim>> method = methods.Of<Dim>();
  if (method == nullptr) {
    method = std::make_shared<GicpRegistration<Dim>>(options.matcher.gicp);
  }
  return std::make_unique<Pipeline<Dim>>(std::move(map), std::move(rig), initial_pose, options,
                                         std::move(method));
}

}  // namespace

// The entrance: a repeated scan is answered from memory, stamps are brought to one clock, and late
// scans are separated from new ones.
struct Localizer::Impl {
  std::unique_ptr<AnyPipeline> pipeline;
  StampMonitor stamp_monitor;
  RadarClocks radar_clocks;
  TimeBase time_base;
  RecentAnswers recent_answers;

  absl::StatusOr<Localization> Localize(const Scan& scan, LocalizerWorkspace& workspace,
                                        StageListener* listener);
  absl::StatusOr<Localization> LocalizeNew(const Scan& scan, LocalizerWorkspace& workspace,
                                           StageListener* listener);
  void AddClocksTo(RigKnowledge& known) const;
  void CheckStamp(std::size_t radar_index, const Scan& scan, LocalizerWorkspace& workspace);
  void CheckOrder(std::size_t radar_index, const Scan& scan, Stamp stamp,
                  LocalizerWorkspace& workspace);
};

absl::StatusOr<Localizer> Localizer::Create(std::shared_ptr<const RadarMap> map, Rig rig,
                                            const std::optional<InitialPose>& initial_pose,
                                            const LocalizerOptions& options,
                                            const RegistrationMethods& methods) {
  if (map == nullptr) return absl::InvalidArgumentError("map must not be null");
  absl::Status status = Validate(rig);
  status.Update(Validate(options));
  if (initial_pose) status.Update(Validate(*initial_pose));
  if (!status.ok()) return status;
  // All six degrees of freedom need a map and a rig that both measure in space.
  const bool in_space = map->info().has_elevation && rig.MeasuresElevation();
  const auto make = in_space ? MakePipeline<3> : MakePipeline<2>;
  std::unique_ptr<AnyPipeline> pipeline =
      make(std::move(map), std::move(rig), initial_pose, options, methods);
  const std::size_t radar_count = pipeline->rig().radars.size();
  return Localizer(
      std::make_unique<Impl>(Impl{.pipeline = std::move(pipeline),
                                  .stamp_monitor = {radar_count, options.stamp_monitor},
                                  .radar_clocks = {radar_count, options.radar_clocks},
                                  .time_base = TimeBase(options.time_base),
                                  .recent_answers = {}}));
}

Localizer::Localizer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Localizer::Localizer(Localizer&&) noexcept = default;
Localizer& Localizer::operator=(Localizer&&) noexcept = default;
Localizer::~Localizer() = default;

absl::StatusOr<Localization> Localizer::Impl::Localize(const Scan& scan,
                                                       LocalizerWorkspace& workspace,
                                                       StageListener* listener) {
  if (absl::Status status = Validate(scan, pipeline->rig()); !status.ok()) return status;
  const std::uint64_t fingerprint = FingerprintOf(scan);
  if (const Localization* answer = recent_answers.Find(fingerprint)) return *answer;
  absl::StatusOr<Localization> answer = LocalizeNew(scan, workspace, listener);
  if (answer.ok() && answer->learned) AddClocksTo(*answer->learned);
  if (answer.ok()) recent_answers.Add(fingerprint, *answer);
  return answer;
}

void Localizer::Impl::AddClocksTo(RigKnowledge& known) const {
  for (std::size_t i = 0; i < pipeline->rig().radars.size(); ++i) {
    if (const std::optional<ScalarEstimate> offset = radar_clocks.OffsetEstimate(i)) {
      known.Of(pipeline->rig().radars[i].id).clock_ahead = *offset;
    }
  }
}

// A clock that may have been set is held against the map, before the scan moves the time.
void Localizer::Impl::CheckStamp(std::size_t radar_index, const Scan& scan,
                                 LocalizerWorkspace& workspace) {
  if (const auto step = stamp_monitor.OnStamp(radar_index, scan.stamp)) {
    const Stamp as_stamped = time_base.Convert(scan.stamp - radar_clocks.Offset(radar_index));
    const auto fit = pipeline->TryFit(scan, as_stamped, workspace);
    const auto other = pipeline->TryFit(scan, as_stamped - *step, workspace);
    // A scan that fits neither way says nothing of the clock: the pose may be wrong.
    const bool is_explained =
        fit && other &&
        (fit->verdict != ScanFit::kContradicts || other->verdict != ScanFit::kContradicts);
    if (is_explained && stamp_monitor.OnFits(radar_index, fit->fit, other->fit)) {
      radar_clocks.OnStep(radar_index, *step);
    }
  }
  pipeline->OnStamp(stamp_monitor.ErrorOf(radar_index));
}

// A clock that is off from the start was never set. Where it is, a scan of its radar was taken
// earlier, and one of another radar fits later if the pose follows that clock.
void Localizer::Impl::CheckOrder(std::size_t radar_index, const Scan& scan, Stamp stamp,
                                 LocalizerWorkspace& workspace) {
  const std::optional<RadarClocks::Suspect> suspect = radar_clocks.Suspected();
  if (!suspect) return;
  const bool is_suspect = radar_index == suspect->index;
  const auto fit = pipeline->TryFit(scan, stamp, workspace);
  const auto moved = pipeline->TryFit(
      scan, is_suspect ? stamp - suspect->ahead : stamp + suspect->ahead, workspace);
  if (fit && moved && radar_clocks.OnFits(*suspect, radar_index, fit->fit, moved->fit)) {
    radar_clocks.OnStep(suspect->index, suspect->ahead);
  }
}

absl::StatusOr<Localization> Localizer::Impl::LocalizeNew(const Scan& scan,
                                                          LocalizerWorkspace& workspace,
                                                          StageListener* listener) {
  const std::size_t index = pipeline->rig().IndexOf(scan.radar_id);
  CheckStamp(index, scan, workspace);
  const std::optional<Stamp> taken = radar_clocks.Align(index, scan.stamp);
  pipeline->ReportClockOffset(index, radar_clocks.IsOff(index));
  if (!taken) {
    const Stamp as_stamped = scan.stamp - radar_clocks.Offset(index);
    return pipeline->LocalizeUntimed(scan, time_base.newest(), time_base.SilenceBefore(as_stamped));
  }
  const absl::StatusOr<TimeBase::ScanTime> time = time_base.ToMonotonic(*taken);
  if (!time.ok()) {
    stamp_monitor.Withdraw(index);
    return time.status();
  }
  CheckOrder(index, scan, time->stamp, workspace);
  return time->is_late ? pipeline->LocalizeLate(scan, time->stamp, workspace)
                       : pipeline->LocalizeNext(scan, *time, workspace, listener);
}

absl::StatusOr<Localization> Localizer::Localize(const Scan& scan, LocalizerWorkspace& workspace,
                                                 StageListener* listener) {
  return impl_->Localize(scan, workspace, listener);
}

absl::StatusOr<Localization> Localizer::Localize(const Scan& scan, StageListener* listener) {
  if (!own_workspace_) own_workspace_ = std::make_unique<LocalizerWorkspace>();
  return Localize(scan, *own_workspace_, listener);
}

absl::StatusOr<FixUse> Localizer::TakeFix(const PositionFix& fix) {
  if (absl::Status status = Validate(fix); !status.ok()) return status;
  return impl_->pipeline->TakeFix(fix.pose, impl_->time_base.Convert(fix.stamp));
}

std::optional<LocalizerSnapshot> Localizer::Snapshot() {
  std::optional<LocalizerSnapshot> snapshot = impl_->pipeline->Snapshot();
  if (!snapshot) return std::nullopt;
  const auto bring_back = [this](Stamp& time) {
    // What never happened has the stamp 0, which a clock that was set may not reach.
    time = std::max(Stamp{}, impl_->time_base.OnVehicleClock(time));
  };
  snapshot->stamp = impl_->time_base.newest();
  bring_back(snapshot->stamp);
  bring_back(snapshot->tracking.observability_changed);
  bring_back(snapshot->tracking.last_accepted);
  if (auto& lost = snapshot->tracking.last_lost_to_outliers) bring_back(*lost);
  for (std::size_t i = 0; i < impl_->pipeline->rig().radars.size(); ++i) {
    snapshot->clocks_ahead.push_back(impl_->radar_clocks.Offset(i));
  }
  return snapshot;
}

absl::Status Localizer::Restore(const LocalizerSnapshot& snapshot) {
  if (absl::Status status = Validate(snapshot); !status.ok()) return status;
  const std::size_t radar_count = impl_->pipeline->rig().radars.size();
  if (!snapshot.clocks_ahead.empty() && snapshot.clocks_ahead.size() != radar_count) {
    return absl::InvalidArgumentError(
        absl::StrFormat("snapshot: clocks_ahead has %d radars; the rig has %d",
                        snapshot.clocks_ahead.size(), radar_count));
  }
  for (std::size_t i = 0; i < snapshot.clocks_ahead.size(); ++i) {
    impl_->radar_clocks.Restore(i, snapshot.clocks_ahead[i]);
  }
  impl_->time_base.Restore(snapshot.stamp);
  impl_->pipeline->Restore(snapshot);
  return absl::OkStatus();
}

bool Localizer::has_pose() const { return impl_->pipeline->has_pose(); }

const Rig& Localizer::rig() const { return impl_->pipeline->rig(); }

}  // namespace dcloc
