#include "client/cli/map/dataset_drives.h"

#include <utility>

#include "client/datasets/whole_drives.h"

namespace dcloc::cli {

absl::StatusOr<std::unique_ptr<DriveReader>> DatasetDrives::Open(std::size_t drive) {
  DriveRequest request = request_;
  request.name = names_[drive];
  absl::StatusOr<Drive> read = ReadDrive(dataset_, request);
  if (!read.ok()) return read.status();
  if (absl::Status status = CheckRadarsOfScans(*read); !status.ok()) return status;
  if (on_open_) on_open_(drive, *read);
  return std::make_unique<WholeDriveReader>(std::make_shared<Drive>(*std::move(read)));
}

}  // namespace dcloc::cli
