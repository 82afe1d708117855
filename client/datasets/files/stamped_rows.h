#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/geometry/pose.h"
#include "core/radar/stamp.h"

namespace dcloc {

/// How stamps are written in a text file: as seconds with decimals, or as whole nanoseconds.
enum class StampUnit { kSeconds, kNanoseconds };

/// A row of a text file: its stamp, and the numbers after it.
struct StampedRow {
  Stamp stamp;
  std::vector<double> values;
};

/// Reads a text file with a row of numbers a line, the first of them a stamp, separated by commas
/// or blanks. Lines that are empty, begin with '#', or are the first one and begin with a letter
/// are left out. Each row has a value for each of `columns`, by whose names errors speak; what
/// stands after them is not looked at. NotFound, or DataLoss that names the path, the line, the
/// column and the value: for a row that is too short, what is no number, and a stamp that is not
/// after the one before.
absl::StatusOr<std::vector<StampedRow>> ReadStampedRows(const std::filesystem::path& path,
                                                        StampUnit unit,
                                                        std::span<const char* const> columns);

/// A pose at a stamp.
struct StampedPose {
  Stamp stamp;
  Pose3 pose;
};

/// Reads poses `stamp x y z qx qy qz qw` a line. Errors as above, and DataLoss for a quaternion
/// whose norm is not 1.
absl::StatusOr<std::vector<StampedPose>> ReadStampedPoses(const std::filesystem::path& path,
                                                          StampUnit unit);

}  // namespace dcloc
