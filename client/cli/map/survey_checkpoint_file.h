#pragma once

#include <map>
#include <string>
#include <utility>

#include "core/mapping/survey_checkpoint.h"

namespace dcloc::cli {

/// A survey's checkpoint in a file. Errors name it.
class SurveyCheckpointFile final : public SurveyCheckpointStore {
 public:
  explicit SurveyCheckpointFile(std::string path) : path_(std::move(path)) {}

  const std::string& name() const override { return path_; }
  absl::StatusOr<std::vector<std::byte>> Read() override;
  absl::Status Write(std::span<const std::byte> bytes) override;

  /// Once it is not needed any more.
  void Remove() const;

 private:
  std::string path_;
};

/// The checkpoints of a survey: before its radars are calibrated in the file that is named, and of
/// each round after it in one beside it, "FILE.1", "FILE.2".
class SurveyCheckpointFiles {
 public:
  /// No file is kept where `path` is empty.
  explicit SurveyCheckpointFiles(std::string path) : path_(std::move(path)) {}

  /// Lives as long as this; null where none is kept.
  SurveyCheckpointStore* OfRound(int round);
  void Remove() const;

 private:
  std::string path_;
  std::map<int, SurveyCheckpointFile> files_;
};

}  // namespace dcloc::cli
