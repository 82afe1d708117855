#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "core/map/radar_map.h"

namespace dcloc::cli {

/// What a map is, for scripts and for people.
nlohmann::ordered_json MapInfoJson(const MapInfo& info);
std::string MapInfoText(const MapInfo& info);

}  // namespace dcloc::cli
