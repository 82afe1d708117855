#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/datasets/drive.h"
#include "client/datasets/drive_request.h"

namespace dcloc {

/// The sequences of HeRCULES at most three folders below `root`, by their path from there, sorted:
/// folders with PR_GT/Continental_gt.txt.
std::vector<std::string> HerculesSequences(const std::filesystem::path& root);

/// Reads the Continental radar of the sequence `request.name`: one file of 29-byte records a scan,
/// poses PR_GT/Continental_gt.txt, turn rates sensor_data/xsens_imu.csv. The vehicle frame is the
/// IMU's, as Calibration/{Continental_LiDAR,IMU_LiDAR}.txt of the sequence or of a folder above
/// tell. NotFound for what is not there, each scan that sensor_data/data_stamp.csv lists too;
/// DataLoss names the file and what is wrong in it.
absl::StatusOr<Drive> ReadHerculesDrive(const std::filesystem::path& root,
                                        const DriveRequest& request);

}  // namespace dcloc
