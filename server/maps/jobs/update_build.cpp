#include "server/maps/jobs/update_build.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/versions/update_builder.h"
#include "server/identity/principal.h"
#include "server/maps/jobs/pass_choice.h"
#include "server/passes/pass_file.h"

namespace dcloc::server {
namespace {

constexpr int kPageSize = 200;

std::string NameOf(const PassRow& row) { return absl::StrCat("pass ", row.number); }

class KeptPassReader final : public DriveReader {
 public:
  KeptPassReader(const PassRow& row, std::filesystem::path path)
      : name_(NameOf(row)),
        scan_count_(static_cast<std::size_t>(row.scan_count)),
        file_(std::move(path)) {}

  absl::Status Begin() {
    absl::StatusOr<Rig> rig = file_.ReadRig();
    if (!rig.ok()) return rig.status();
    rig_ = *std::move(rig);
    return absl::OkStatus();
  }

  const std::string& name() const override { return name_; }
  const Rig& rig() const override { return rig_; }
  std::size_t scan_count() const override { return scan_count_; }

  absl::StatusOr<const Scan*> Next() override {
    const absl::StatusOr<bool> there = file_.Next(&scan_);
    if (!there.ok()) return there.status();
    return *there ? &scan_ : nullptr;
  }

 private:
  const std::string name_;
  const std::size_t scan_count_;
  PassFile file_;
  Rig rig_;
  Scan scan_;
};

/// Passes of the store, of which one is fetched at a time.
class KeptPasses final : public DriveSource {
 public:
  KeptPasses(const std::vector<PassRow>& rows, const UpdateSources& sources)
      : rows_(rows), sources_(sources) {}

  std::size_t drive_count() const override { return rows_.size(); }

  absl::StatusOr<std::unique_ptr<DriveReader>> Open(std::size_t drive) override {
    const PassRow& row = rows_[drive];
    const std::filesystem::path path = sources_.folder / ("pass-" + row.pass_id);
    absl::Status status = sources_.passes.Fetch(row, path);
    if (absl::IsNotFound(status)) {
      return absl::AbortedError(absl::StrCat(NameOf(row), " was removed meanwhile; begin anew"));
    }
    if (!status.ok()) return status;
    auto reader = std::make_unique<KeptPassReader>(row, path);
    status = reader->Begin();
    if (!status.ok()) return status;
    return reader;
  }

 private:
  const std::vector<PassRow>& rows_;
  const UpdateSources& sources_;
};

absl::StatusOr<std::vector<PassRow>> ListAll(const UpdateSources& sources) {
  std::vector<PassRow> rows;
  std::int64_t below = std::numeric_limits<std::int64_t>::max();
  while (true) {
    auto page = sources.passes.rows().List(sources.tenant, sources.map_name, below, kPageSize);
    if (!page.ok()) return page.status();
    for (PassRow& row : *page) rows.push_back(std::move(row));
    if (page->size() < kPageSize) return rows;
    below = rows.back().number;
  }
}

/// Of the version at the first pass, by this server's clock: those of vehicles may be any. The
/// drive that it was made of is older.
double AgeInDays(const MapVersionRecord& version, const std::vector<PassRow>& passes) {
  const auto first = std::ranges::min_element(passes, {}, &PassRow::create_time)->create_time;
  return std::chrono::duration<double, std::ratio<86'400>>(first - version.create_time).count();
}

void TellPasses(const JudgedUpdate& update, BuildProgress& progress) {
  for (std::size_t i = 0; i < update.passes.size(); ++i) {
    v1::MapBuildDriveResult result;
    result.set_name(update.passes[i].name);
    result.set_in_map(update.faults[i].empty());
    result.set_reason(update.faults[i]);
    result.set_length_m(update.passes[i].length_m);
    progress.AddDrive(std::move(result));
    if (update.faults[i].empty()) progress.CountScans(update.passes[i].GoodCount());
  }
}

v1::MapUpdateResult ResultOf(const JudgedUpdate& update, std::int64_t base_version) {
  v1::MapUpdateResult result;
  result.set_base_version(base_version);
  const auto count = [](const std::vector<LandmarkHistory>& landmarks, LandmarkFate fate) {
    return std::ranges::count(landmarks, fate, &LandmarkHistory::fate);
  };
  result.set_added_count(count(update.update.found, LandmarkFate::kAdded));
  result.set_removed_count(count(update.update.known, LandmarkFate::kRemoved));
  result.set_kept_count(count(update.update.known, LandmarkFate::kKept));
  result.set_judged_by(update.held_out);
  result.set_is_better(update.gate.is_better);
  result.set_reason(update.gate.reason);
  result.set_old_error_m(update.gate.whole.old_version.error_m);
  result.set_new_error_m(update.gate.whole.new_version.error_m);
  result.set_old_tracking_share(update.gate.whole.old_version.tracking_share);
  result.set_new_tracking_share(update.gate.whole.new_version.tracking_share);
  return result;
}

std::string DescriptionOf(const BuildRequest& request, const JudgedUpdate& update,
                          std::int64_t base_version) {
  const std::string what =
      request.options.description.empty() ? "" : request.options.description + "; ";
  return absl::StrCat(what, "version ", base_version, " after ", update.update.order.size(),
                      " passes, ", DescribeJudgement(update));
}

}  // namespace

absl::StatusOr<std::vector<std::byte>> BuildFromPasses(const BuildRequest& request,
                                                       const UpdateSources& sources,
                                                       BuildProgress& progress) {
  const absl::StatusOr<LoadedMap> base =
      sources.store.Acquire(ScopedMapName(sources.tenant, sources.map_name), request.base_version);
  if (!base.ok()) return base.status();
  const absl::StatusOr<std::vector<PassRow>> rows = ListAll(sources);
  if (!rows.ok()) return rows.status();
  const absl::StatusOr<PassChoice> choice =
      ChoosePasses(*rows, base->record.create_time, sources.max_bytes);
  if (!choice.ok()) return choice.status();
  KeptPasses passes(choice->passes, sources);
  std::int64_t scan_count = 0;
  for (const PassRow& row : choice->passes) scan_count += row.scan_count;
  progress.SetScanCount(scan_count);
  UpdateDrives drives{.source = passes, .vehicles = {}, .held_out = choice->held_out};
  for (const PassRow& row : choice->passes) drives.vehicles.push_back(row.vehicle);
  MapUpdateOptions options;
  options.base_age_days = std::max(options.base_age_days, AgeInDays(base->record, choice->passes));
  const EditableMap base_map = ToEditable(*base->map);
  absl::StatusOr<JudgedUpdate> update = BuildUpdate(
      base_map, drives, options,
      [&](const std::string& stage, double share) { return progress.Tell(stage, share); });
  if (!update.ok()) return update.status();
  TellPasses(*update, progress);
  progress.SetUpdate(ResultOf(*update, base->record.version));
  if (!update->gate.is_better) {
    return absl::FailedPreconditionError(
        absl::StrCat("no version was made: ", update->gate.reason));
  }
  EditableMap& map = update->update.map;
  map.description = DescriptionOf(request, *update, base->record.version);
  return ToMapBytes(map);
}

}  // namespace dcloc::server
