#include "server/maps/jobs/survey_build.h"

#include <memory>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "core/mapping/survey_builder.h"
#include "server/base/status.h"
#include "server/convert/calibration.h"
#include "server/convert/scan.h"

namespace dcloc::server {
namespace {

/// A drive in the spool.
struct SpooledDrive {
  std::string name;
  Rig rig;
  std::int64_t position = 0;  ///< of its first scan
  std::size_t scan_count = 0;
};

class SpooledDriveReader final : public DriveReader {
 public:
  SpooledDriveReader(const SpooledDrive& drive, FramedReader& spool)
      : drive_(drive), spool_(spool) {}

  const std::string& name() const override { return drive_.name; }
  const Rig& rig() const override { return drive_.rig; }
  std::size_t scan_count() const override { return drive_.scan_count; }

  absl::StatusOr<const Scan*> Next() override {
    if (read_count_ == drive_.scan_count) return nullptr;
    const absl::StatusOr<bool> there = spool_.Next(&message_);
    if (!there.ok()) return there.status();
    absl::Status status = convert::FromProto(message_.scan().scan(), drive_.rig, &scan_);
    if (!status.ok()) {
      return WithPrefix(absl::StrCat(drive_.name, ", scan ", read_count_, ": "), status);
    }
    ++read_count_;
    return &scan_;
  }

 private:
  const SpooledDrive& drive_;
  FramedReader& spool_;
  std::size_t read_count_ = 0;
  v1::StartMapBuildRequest message_;
  Scan scan_;
};

/// The drives of a survey. One is read at a time.
class SpooledDrives final : public DriveSource {
 public:
  explicit SpooledDrives(FramedReader& spool) : spool_(spool) {}

  /// Looks through the spool once. Cancelled when `progress` is stopped.
  absl::Status Find(BuildProgress& progress) {
    v1::StartMapBuildRequest message;
    while (progress.Tell("reading drives", 0.0)) {
      const absl::StatusOr<bool> there = spool_.Next(&message);
      if (!there.ok() || !*there) return there.status();
      if (!message.has_drive()) {
        if (drives_.empty()) return absl::DataLossError("the scans have no drive");
        ++drives_.back().scan_count;
        continue;
      }
      absl::StatusOr<Rig> rig = convert::FromProto(message.drive().rig(), "drive.rig");
      if (!rig.ok()) return rig.status();
      drives_.push_back({.name = message.drive().name(),
                         .rig = *std::move(rig),
                         .position = spool_.position(),
                         .scan_count = 0});
    }
    return BuildStopped();
  }

  std::size_t drive_count() const override { return drives_.size(); }

  absl::StatusOr<std::unique_ptr<DriveReader>> Open(std::size_t drive) override {
    if (absl::Status status = spool_.Begin(drives_[drive].position); !status.ok()) return status;
    return std::make_unique<SpooledDriveReader>(drives_[drive], spool_);
  }

  const std::vector<SpooledDrive>& drives() const { return drives_; }

 private:
  FramedReader& spool_;
  std::vector<SpooledDrive> drives_;
};

MapBuilderOptions OptionsOf(const BuildRequest& request, const std::vector<SpooledDrive>& drives) {
  MapBuilderOptions options = request.options;
  if (options.name.empty()) options.name = drives.front().name;
  if (options.description.empty()) {
    const auto name = [](std::string* text, const SpooledDrive& drive) { *text += drive.name; };
    options.description = absl::StrCat("survey of ", absl::StrJoin(drives, ", ", name));
  }
  return options;
}

void TellDrives(const SurveyBuilder& builder, BuildProgress& progress) {
  for (std::size_t i = 0; i < builder.tracks().size(); ++i) {
    const SurveyedDrive& drive = builder.survey().drives[i];
    v1::MapBuildDriveResult result;
    result.set_name(drive.name);
    result.set_in_map(drive.is_in_map);
    result.set_reason(drive.reason);
    result.set_length_m(builder.tracks()[i].arc_length_m);
    progress.AddDrive(std::move(result));
  }
}

void TellRadars(const SurveyBuilder& builder, BuildProgress& progress) {
  for (const RadarCalibration& radar : builder.calibrations()) {
    v1::SurveyedRadar result;
    convert::ToProto(radar, &result);
    progress.AddRadar(std::move(result));
  }
}

}  // namespace

absl::StatusOr<std::vector<std::byte>> BuildBySurvey(const BuildRequest& request,
                                                     FramedReader& spool, BuildProgress& progress) {
  SpooledDrives drives(spool);
  if (absl::Status status = drives.Find(progress); !status.ok()) return status;
  SurveyBuilder builder(
      drives, [&](const char* stage, double share) { return progress.Tell(stage, share); });
  absl::Status status = builder.Track();
  if (status.ok()) status = builder.Place({});
  if (status.ok()) status = builder.Calibrate({});
  if (status.ok()) status = builder.CorrectScale();
  if (!status.ok()) return status;
  TellDrives(builder, progress);
  TellRadars(builder, progress);
  absl::StatusOr<std::vector<std::byte>> bytes = builder.Fuse(OptionsOf(request, drives.drives()));
  for (std::size_t i = 0; bytes.ok() && i < drives.drives().size(); ++i) {
    if (builder.survey().drives[i].is_in_map) progress.CountScans(drives.drives()[i].scan_count);
  }
  return bytes;
}

}  // namespace dcloc::server
