#pragma once

#include <fstream>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/evaluation/outcome.h"
#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::cli {

/// The answers as files, written as they come: a CSV line each,
/// `stamp_ns,radar,state,x,y,z,qx,qy,qz,qw,c00,...,c55,latency_ms,map_version` with the wire's
/// covariance (fixed axes of the map) and numbers to the last bit; and, where asked for, a line
/// `stamp x y z qx qy qz qw` in seconds for each pose in the map (TUM), not for states
/// INITIALIZING.
class AnswerFiles {
 public:
  /// `tum_path` may be empty. Errors name the path and the reason.
  static absl::StatusOr<AnswerFiles> Create(const std::string& csv_path,
                                            const std::string& tum_path);

  /// `outcome` is what `result` says, with the round trip in `total_ms`.
  void Add(const v1::LocalizationResult& result, const ScanOutcome& outcome);

  /// Ends the files; an error when not everything could be written.
  absl::Status Close();

 private:
  struct File {
    std::string path;
    std::ofstream stream;
  };
  static absl::Status Open(const std::string& path, File& file);
  static absl::Status Close(File& file);

  File csv_;
  File tum_;
};

}  // namespace dcloc::cli
