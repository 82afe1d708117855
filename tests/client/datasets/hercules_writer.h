#pragma once

#include <filesystem>
#include <string>

#include "client/datasets/drive.h"

namespace dcloc {

/// Writes a drive of one radar as a sequence of HeRCULES: a file of 29-byte records a scan, the
/// list of them, turn rates, the radar's poses, and a calibration by which the drive's vehicle
/// frame is that of the IMU.
void WriteHercules(const Drive& drive, const std::filesystem::path& root, const std::string& name);

}  // namespace dcloc
