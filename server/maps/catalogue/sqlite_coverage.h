#pragma once

#include <vector>

#include "server/base/sqlite.h"
#include "server/maps/catalogue/catalogue.h"

/// The catalogue's boxes of mapped street and the R*Trees over them: one over map-local metres, one
/// over degrees. The trees' own bounds are 32-bit floats, which SQLite rounds outwards; the exact
/// ones stand in the table. Triggers keep the trees in step with it, and it goes with its version.
namespace dcloc::server {

/// Makes the table `coverage_box`, the trees, and the trigger that deletes from them.
extern const char* const kCreateCoverage;

/// Makes the trigger that inserts into the trees, in place of an earlier one. A tree may have an
/// entry too many, which no box has: SQLite leaves it behind when a read fails while a box is
/// added. The next box of that number takes its place.
extern const char* const kCreateCoverageInsert;

absl::Status InsertCoverage(SqliteDatabase& database, absl::string_view map_name,
                            std::int64_t version, const std::vector<CoverageBox>& boxes);

/// As Catalogue::FindCoverage, by name and in any number.
absl::StatusOr<std::vector<CoverageRecord>> FindMapCoverage(SqliteDatabase& database,
                                                            absl::string_view map_name,
                                                            const Eigen::Vector2d& p_map,
                                                            double radius_m);
absl::StatusOr<std::vector<CoverageRecord>> FindEarthCoverage(SqliteDatabase& database,
                                                              absl::string_view prefix,
                                                              const GeodeticPosition& position,
                                                              double radius_m);

}  // namespace dcloc::server
