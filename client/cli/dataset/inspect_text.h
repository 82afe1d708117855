#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "client/datasets/bag_mapping.h"
#include "client/datasets/bag_overview.h"
#include "client/datasets/check/range_rate_check.h"
#include "client/datasets/check/scan_statistics.h"
#include "client/datasets/drive.h"

namespace dcloc::cli {

/// What a bag holds, topic by topic: for people, and for scripts.
std::string OverviewText(const std::string& name, const BagOverview& overview);
nlohmann::ordered_json OverviewJson(const BagOverview& overview);

/// A mapping as `dcloc_bag.json` has it.
std::string MappingText(const BagMapping& mapping);

/// A drive's radars, with what their range rates are. Statistics and checks are in the rig's order.
std::string DriveText(const Drive& drive, const std::vector<ScanStatistics>& statistics,
                      const std::vector<RangeRateCheck>& checks);
nlohmann::ordered_json DriveJson(const Drive& drive, const std::vector<ScanStatistics>& statistics,
                                 const std::vector<RangeRateCheck>& checks);

}  // namespace dcloc::cli
