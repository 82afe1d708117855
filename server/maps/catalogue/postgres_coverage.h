#pragma once

#include <vector>

#include "server/maps/catalogue/catalogue.h"
#include "server/postgres/postgres_connection.h"

/// The catalogue's boxes of mapped street in PostGIS.
namespace dcloc::server {

absl::Status InsertCoverage(PostgresConnection& connection, absl::string_view map_name,
                            std::int64_t version, const std::vector<CoverageBox>& boxes);

/// As Catalogue::FindCoverage, by name and in any number; without boxes also when there is no map.
absl::StatusOr<std::vector<CoverageRecord>> FindMapCoverage(PostgresConnection& connection,
                                                            absl::string_view map_name,
                                                            const Eigen::Vector2d& p_map,
                                                            double radius_m);
absl::StatusOr<std::vector<CoverageRecord>> FindEarthCoverage(PostgresConnection& connection,
                                                              absl::string_view prefix,
                                                              const GeodeticPosition& position,
                                                              double radius_m);

}  // namespace dcloc::server
