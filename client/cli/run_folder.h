#pragma once

#include <filesystem>
#include <string>

#include "client/evaluation/paper/study.h"

namespace dcloc::cli {

/// Finished runs of a study as files, each written whole or not at all.
class RunFolder final : public paper::RunStore {
 public:
  /// Runs of another `fingerprint` are as if they were not there.
  RunFolder(std::filesystem::path folder, std::string fingerprint)
      : folder_(std::move(folder)), fingerprint_(std::move(fingerprint)) {}

  std::optional<DriveOutcome> Load(const std::string& run_name) override;
  absl::Status Save(const std::string& run_name, const DriveOutcome& outcome) override;

 private:
  std::filesystem::path PathOf(const std::string& run_name) const {
    return folder_ / (run_name + ".json");
  }

  std::filesystem::path folder_;
  std::string fingerprint_;
};

/// A hash of the running program, so that results of another build are not taken for this one's.
std::string ProgramHash();

}  // namespace dcloc::cli
