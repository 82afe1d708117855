#pragma once

#include <chrono>
#include <string>

#include "server/maps/catalogue/build_queue.h"

/// How the columns of a build are read, alike in all implementations of the queue.
namespace dcloc::server {

inline constexpr char kBuildColumns[] =
    "build_id, tenant, map_name, state, create_time_ns, input_sha256, report, attempt_count";

inline std::string SelectBuilds(const char* rest) {
  return std::string("SELECT ") + kBuildColumns + " FROM map_build " + rest;
}

inline std::int64_t NumberOf(BuildState state) { return static_cast<std::int64_t>(state); }

/// A row of `kBuildColumns`; `read_report` takes the next column, which is bytes.
template <typename Row, typename ReadReport>
BuildRow NextBuild(Row& row, const ReadReport& read_report) {
  BuildRow build;
  build.build_id = row.NextText();
  build.tenant = row.NextText();
  build.map_name = row.NextText();
  build.state = static_cast<BuildState>(row.NextInteger());
  build.create_time = SystemTime(std::chrono::nanoseconds(row.NextInteger()));
  build.input_sha256 = row.NextText();
  build.report = read_report(row);
  build.attempt_count = row.NextInteger();
  return build;
}

}  // namespace dcloc::server
