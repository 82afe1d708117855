#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"

namespace dcloc {

/// One drive, read scan by scan.
class DriveReader {
 public:
  virtual ~DriveReader() = default;
  virtual const std::string& name() const = 0;
  virtual const Rig& rig() const = 0;  ///< valid
  virtual std::size_t scan_count() const = 0;
  /// The next scan, by ascending stamp, until the call after; null after the last one.
  virtual absl::StatusOr<const Scan*> Next() = 0;
};

/// Drives, wherever they are kept. Each can be opened several times, and gives the same scans.
class DriveSource {
 public:
  virtual ~DriveSource() = default;
  virtual std::size_t drive_count() const = 0;
  virtual absl::StatusOr<std::unique_ptr<DriveReader>> Open(std::size_t drive) = 0;
};

}  // namespace dcloc
