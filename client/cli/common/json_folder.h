#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "absl/status/status.h"

namespace dcloc::cli {

/// Results by name as files, each written whole or not at all.
class JsonFolder {
 public:
  /// Results with another `fingerprint` are ignored.
  JsonFolder(std::filesystem::path folder, std::string fingerprint)
      : folder_(std::move(folder)), fingerprint_(std::move(fingerprint)) {}

  std::optional<nlohmann::json> Load(const std::string& name) const;
  absl::Status Save(const std::string& name, const nlohmann::json& result) const;

 private:
  std::filesystem::path PathOf(const std::string& name) const { return folder_ / (name + ".json"); }

  std::filesystem::path folder_;
  std::string fingerprint_;
};

/// A hash of the running program, so that results of another build are not taken for this one's.
std::string ProgramHash();

/// Makes `folder` and those above it, where they are missing.
absl::Status MakeFolder(const std::filesystem::path& folder);

}  // namespace dcloc::cli
