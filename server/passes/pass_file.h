#pragma once

#include <cstdint>
#include <filesystem>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"
#include "dcloc/v1/pass_service.pb.h"
#include "server/base/framed_file.h"

namespace dcloc::server {

inline constexpr std::int32_t kPassFormatVersion = 1;

/// Reads a pass's file, and removes it at its end. Vehicles sent what is in it, so each scan is
/// checked again. Not thread-safe.
class PassFile {
 public:
  explicit PassFile(std::filesystem::path path) : file_(std::move(path)) {}

  /// The radars; to be called first. DataLoss: it is no pass; InvalidArgument names what is wrong
  /// with the rig.
  absl::StatusOr<Rig> ReadRig();

  /// Fills `scan`; false after the last one. DataLoss; InvalidArgument names the field.
  absl::StatusOr<bool> Next(Scan* scan);

 private:
  FramedReader file_;
  Rig rig_;
  v1::PassEntry entry_;
};

}  // namespace dcloc::server
