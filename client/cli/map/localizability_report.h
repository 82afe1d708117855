#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/localizability/localizability.h"
#include "core/map/radar_map.h"

namespace dcloc::cli {

/// How good a map is: what it holds, and what vehicles can expect of it.
struct LocalizabilityReport {
  std::string file;
  std::shared_ptr<const RadarMap> map;
  std::vector<KeyframeLocalizability> keyframes;  ///< in the map's order
};

/// A row for each keyframe, and the whole.
nlohmann::ordered_json LocalizabilityJson(const LocalizabilityReport& report);
std::string LocalizabilityText(const LocalizabilityReport& report);

/// The same as a page with a drawing.
std::string LocalizabilityHtml(const LocalizabilityReport& report);

}  // namespace dcloc::cli
