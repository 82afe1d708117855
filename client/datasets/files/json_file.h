#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "absl/status/statusor.h"

namespace dcloc {

/// The whole of a small JSON file. NotFound, or DataLoss that names the file and where it breaks.
absl::StatusOr<nlohmann::json> ReadJson(const std::filesystem::path& path);

}  // namespace dcloc
