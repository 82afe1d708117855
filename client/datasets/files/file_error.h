#pragma once

#include <filesystem>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace dcloc {

/// What is wrong with the contents of a file: DataLoss, "<path>: <what>".
inline absl::Status FileError(const std::filesystem::path& path, absl::string_view what) {
  return absl::DataLossError(absl::StrCat(path.string(), ": ", what));
}

/// NotFound where there is no such file, otherwise that it cannot be read.
inline absl::Status CannotOpen(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    return absl::NotFoundError(absl::StrCat(path.string(), ": there is no such file"));
  }
  return absl::PermissionDeniedError(absl::StrCat(path.string(), ": cannot be read"));
}

}  // namespace dcloc
