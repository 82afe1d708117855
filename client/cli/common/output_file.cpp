#include "client/cli/common/output_file.h"

#include <system_error>

#include "absl/strings/str_cat.h"

namespace dcloc::cli {

void AddForceOption(CLI::App& command, bool& force) {
  command.add_flag("--force", force, "Replace files that are there already");
}

absl::Status CheckOutputFiles(const OutputFiles& files) {
  std::vector<std::filesystem::path> seen;
  for (const std::string& file : files.paths) {
    if (file.empty()) continue;
    std::error_code error;
    const auto path = std::filesystem::weakly_canonical(file, error);
    for (const auto& other : seen) {
      if (path != other) continue;
      return absl::InvalidArgumentError(absl::StrCat(file, ": two outputs would have this path"));
    }
    seen.push_back(path);
    if (files.force || !std::filesystem::exists(file, error)) continue;
    return absl::AlreadyExistsError(absl::StrCat(file, ": is there already; --force replaces it"));
  }
  return absl::OkStatus();
}

}  // namespace dcloc::cli
