#include "server/maps/jobs/build_intake.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/base/check.h"
#include "server/base/status.h"
#include "server/convert/geometry.h"
#include "server/convert/scan.h"
#include "server/maps/jobs/map_build.h"

namespace dcloc::server {
namespace {

constexpr std::size_t kMaxDrives = 100;
constexpr std::size_t kMaxDriveName = 100;

}  // namespace

absl::Status BuildIntake::Take(const v1::StartMapBuildRequest& message) {
  absl::Status status;
  if (!has_header_) {
    status = message.has_header() ? TakeHeader(message.header()) : Missing("header");
  } else if (is_update()) {
    status = NotTaken("a message after the header", input_.method, "the server has the passes");
  } else if (message.has_drive()) {
    status = TakeDrive(message.drive());
  } else {
    status = message.has_scan() ? TakeScan(message.scan()) : Missing("scan");
  }
  return status.ok() ? input_.spool->Append(message, max_bytes_) : status;
}

absl::StatusOr<BuildInput> BuildIntake::Finish() {
  if (!has_header_) return Missing("header");
  if (is_survey() && drives_.empty()) return Missing("drive");
  if (is_survey()) {
    if (absl::Status status = CheckDriveHasScans(); !status.ok()) return status;
  }
  if (input_.scan_count == 0 && !is_update()) return Missing("scan");
  absl::StatusOr<std::string> sha256 = input_.spool->Finish();
  if (!sha256.ok()) return sha256.status();
  input_.sha256 = *std::move(sha256);
  return std::move(input_);
}

absl::Status BuildIntake::TakeHeader(const v1::MapBuildHeader& header) {
  absl::StatusOr<BuildRequest> request = FromProto(header);
  if (!request.ok()) return request.status();
  absl::StatusOr<std::unique_ptr<ScanSpool>> spool = ScanSpool::Create(folder_);
  if (!spool.ok()) return spool.status();
  has_header_ = true;
  rig_ = std::move(request->rig);
  input_ = {.map_name = header.map_name(),
            .method = header.method(),
            .scan_count = 0,
            .spool = *std::move(spool),
            .sha256 = ""};
  return absl::OkStatus();
}

absl::Status BuildIntake::TakeDrive(const v1::MapBuildDrive& drive) {
  if (!is_survey()) {
    return absl::InvalidArgumentError(
        "drive is given; only header.method MAP_BUILD_METHOD_SURVEY takes drives");
  }
  if (!drives_.empty()) {
    if (absl::Status status = CheckDriveHasScans(); !status.ok()) return status;
  }
  if (drive.name().empty() || drive.name().size() > kMaxDriveName) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "drive.name has %d bytes; it must have 1 to %d", drive.name().size(), kMaxDriveName));
  }
  if (drives_.size() == kMaxDrives) {
    return absl::InvalidArgumentError(
        absl::StrFormat("drive %s is one too many; a survey has at most %d drives",
                        Quoted(drive.name()), kMaxDrives));
  }
  if (!drives_.insert(drive.name()).second) {
    return absl::InvalidArgumentError(
        absl::StrCat("drive.name is ", Quoted(drive.name()), ", as of a drive before"));
  }
  absl::StatusOr<Rig> rig = convert::FromProto(drive.rig(), "drive.rig");
  if (!rig.ok())
    return WithPrefix(absl::StrCat("drive ", Quoted(drive.name()), ": "), rig.status());
  rig_ = *std::move(rig);
  drive_ = drive.name();
  drive_scan_count_ = 0;
  last_stamp_.reset();
  return absl::OkStatus();
}

absl::Status BuildIntake::TakeScan(const v1::PosedScan& scan) {
  if (absl::Status status = CheckScan(scan); !status.ok()) return WithPrefix(Where(), status);
  last_stamp_ = scan_.stamp;
  ++drive_scan_count_;
  ++input_.scan_count;
  return absl::OkStatus();
}

absl::Status BuildIntake::CheckScan(const v1::PosedScan& message) {
  if (is_survey()) {
    if (drives_.empty()) return Missing("drive");
    if (message.has_t_map_vehicle())
      return NotTaken("t_map_vehicle", input_.method, "it finds the poses");
    if (message.begins_pass())
      return NotTaken("begins_pass", input_.method, "a drive message begins a pass");
  }
  absl::Status status = WithPrefix("scan.", convert::FromProto(message.scan(), rig_, &scan_));
  if (!status.ok()) return status;
  if (!is_survey()) {
    if (!message.has_t_map_vehicle()) return Missing("t_map_vehicle");
    status = convert::FromProto(message.t_map_vehicle(), "t_map_vehicle").status();
    if (message.begins_pass()) last_stamp_.reset();
  }
  if (status.ok() && last_stamp_ && scan_.stamp < *last_stamp_) {
    return absl::InvalidArgumentError(
        absl::StrFormat("scan.stamp_ns is %d; it must not lie before %d, the scan's before it",
                        message.scan().stamp_ns(), last_stamp_->time_since_epoch().count()));
  }
  return status;
}

std::string BuildIntake::Where() const {
  if (!is_survey()) return absl::StrCat("scan ", input_.scan_count, ": ");
  return absl::StrCat("drive ", Quoted(drive_), ", scan ", drive_scan_count_, ": ");
}

absl::Status BuildIntake::CheckDriveHasScans() const {
  if (drive_scan_count_ > 0) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("drive ", Quoted(drive_), " has no scan"));
}

}  // namespace dcloc::server
