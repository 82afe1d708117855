#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "client/datasets/drive.h"
#include "core/mapping/drive_source.h"

namespace dcloc {

/// A drive that was read whole, scan by scan.
class WholeDriveReader final : public DriveReader {
 public:
  explicit WholeDriveReader(std::shared_ptr<const Drive> drive) : drive_(std::move(drive)) {}

  const std::string& name() const override { return drive_->name; }
  const Rig& rig() const override { return drive_->rig; }
  std::size_t scan_count() const override { return drive_->scans.size(); }
  absl::StatusOr<const Scan*> Next() override {
    return next_ == drive_->scans.size() ? nullptr : &drive_->scans[next_++].scan;
  }

 private:
  std::shared_ptr<const Drive> drive_;
  std::size_t next_ = 0;
};

/// Drives that were read whole. They outlive it.
class WholeDrives final : public DriveSource {
 public:
  explicit WholeDrives(std::span<const Drive> drives) : drives_(drives) {}

  std::size_t drive_count() const override { return drives_.size(); }
  absl::StatusOr<std::unique_ptr<DriveReader>> Open(std::size_t drive) override {
    const std::shared_ptr<const Drive> borrowed(std::shared_ptr<void>(), &drives_[drive]);
    return std::make_unique<WholeDriveReader>(borrowed);
  }

 private:
  std::span<const Drive> drives_;
};

}  // namespace dcloc
