#pragma once

#include <nlohmann/json.hpp>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace dcloc {

/// A GeoJSON file's text as JSON. It is not parsed where it is nested more than 32 deep, as values
/// are copied and printed by recursion. `name` is for errors: DataLoss for what is no JSON,
/// InvalidArgument naming the depth and the bound.
absl::StatusOr<nlohmann::json> ParseGeoJson(absl::string_view text, absl::string_view name);

/// The object's member; null where there is none, or `json` is no object.
const nlohmann::json& MemberOf(const nlohmann::json& json, const char* name);

}  // namespace dcloc
