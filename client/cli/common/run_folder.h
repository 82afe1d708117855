#pragma once

#include <filesystem>
#include <string>

#include "client/cli/common/json_folder.h"
#include "client/evaluation/paper/study.h"

namespace dcloc::cli {

/// Finished runs of a study as files.
class RunFolder final : public paper::RunStore {
 public:
  /// As of JsonFolder.
  RunFolder(std::filesystem::path folder, std::string fingerprint)
      : files_(std::move(folder), std::move(fingerprint)) {}

  std::optional<DriveOutcome> Load(const std::string& run_name) override;
  absl::Status Save(const std::string& run_name, const DriveOutcome& outcome) override;

 private:
  JsonFolder files_;
};

}  // namespace dcloc::cli
