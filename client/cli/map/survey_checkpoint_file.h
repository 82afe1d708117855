#pragma once

#include <string>

#include "core/mapping/survey_checkpoint.h"

namespace dcloc::cli {

/// A survey's checkpoint in a file. Errors name it.
class SurveyCheckpointFile final : public SurveyCheckpointStore {
 public:
  /// `path` outlives it.
  explicit SurveyCheckpointFile(const std::string& path) : path_(path) {}

  const std::string& name() const override { return path_; }
  absl::StatusOr<std::vector<std::byte>> Read() override;
  absl::Status Write(std::span<const std::byte> bytes) override;

  /// Once it is not needed any more.
  void Remove() const;

 private:
  const std::string& path_;
};

}  // namespace dcloc::cli
