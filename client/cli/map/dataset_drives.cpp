#include "client/cli/map/dataset_drives.h"

#include <utility>

namespace dcloc::cli {
namespace {

/// A drive of a data set that was read whole.
class ReadDriveReader final : public DriveReader {
 public:
  explicit ReadDriveReader(Drive drive) : drive_(std::move(drive)) {}
  const std::string& name() const override { return drive_.name; }
  const Rig& rig() const override { return drive_.rig; }
  std::size_t scan_count() const override { return drive_.scans.size(); }
  absl::StatusOr<const Scan*> Next() override {
    return next_ == drive_.scans.size() ? nullptr : &drive_.scans[next_++].scan;
  }

 private:
  const Drive drive_;
  std::size_t next_ = 0;
};

}  // namespace

absl::StatusOr<std::unique_ptr<DriveReader>> DatasetDrives::Open(std::size_t drive) {
  DriveRequest request = request_;
  request.name = names_[drive];
  absl::StatusOr<Drive> read = ReadDrive(dataset_, request);
  if (!read.ok()) return read.status();
  if (absl::Status status = CheckRadarsOfScans(*read); !status.ok()) return status;
  if (on_open_) on_open_(drive, *read);
  return std::make_unique<ReadDriveReader>(*std::move(read));
}

}  // namespace dcloc::cli
