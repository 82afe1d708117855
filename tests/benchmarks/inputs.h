#pragma once

#include <memory>
#include <string>
#include <vector>

#include "client/datasets/drive.h"
#include "core/geometry/gaussian_point.h"
#include "core/map/local_map.h"
#include "core/map/radar_map.h"
#include "core/submap/submap.h"

namespace dcloc::benchmarks {

/// Whether a benchmark was called with --smoke: only to see that it runs. Ends the program with its
/// usage where it was called otherwise.
bool IsSmokeRun(int argc, char** argv);

/// A street driven twice: what is measured works on the same scans, map and numbers every time.
struct Case {
  std::string name;
  Drive map_drive;
  Drive live_drive;
  std::vector<std::byte> map_bytes;
  std::shared_ptr<const RadarMap> map;
};

/// A made-up town, the map pass at 72 km/h and the live pass at 40 km/h: "ars408" is one radar of
/// about 55 targets a scan, "carla" one of about 125, so that a sub-map has about 1,000 points.
Case SimulatedCase(const std::string& name, double length_m);

/// Drives recorded by real vehicles, each mapped with some of its radars and localized with others.
/// Empty when DCLOC_DATA names no folder that has them.
std::vector<Case> RecordedCases();

/// One live sub-map with where it truly lies.
struct Query {
  Submap submap;
  std::vector<GaussianPoint<2>> live;  ///< the sub-map's points in the plane
  LocalMap<2> local_map;               ///< around the vehicle
  Pose2 T_local_vehicle_true;
};

/// Sub-maps along the live drive, every `stride`-th scan from the tenth on, at most `max_count`.
std::vector<Query> Queries(const Case& drives, std::size_t stride, std::size_t max_count);

/// `query`'s true pose, `translation_m` and `rotation_deg` off to sides that turn with `number`.
Pose2 StartFor(const Query& query, std::size_t number, double translation_m, double rotation_deg);

}  // namespace dcloc::benchmarks
