// A map of up to 1,000 km of street, made of shifted copies of one: opening, memory, cost of a
// scan.
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/localizer/localizer.h"
#include "core/map/keyframe_index.h"
#include "core/map/map_file.h"
#include "tests/benchmarks/inputs.h"

namespace dcloc::benchmarks {
namespace {

constexpr int kVehicles = 50;

double CpuMilliseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

// Copies lie side by side, so far apart that no scan sees two.
Eigen::Vector3d OffsetOf(int copy) {
  constexpr int kRow = 32;
  constexpr double kApart_m = 3000.0;
  const int column = copy % kRow;
  const int row = copy / kRow;
  return kApart_m * Eigen::Vector3d(column, row, 0.0);
}

// Writes `copies` of `map` as one file, the points piece by piece: they need not fit into memory.
std::uint64_t WriteCopies(const RadarMap& map, int copies, const std::filesystem::path& path) {
  const MapFileView part = *ParseMapFile(map.bytes());
  MapFileView whole = part;
  std::vector<KeyframeRecord> keyframes;
  for (int copy = 0; copy < copies; ++copy) {
    for (KeyframeRecord keyframe : part.keyframes) {
      for (std::size_t i = 0; i < 3; ++i) {
        keyframe.translation_local_m[i] += OffsetOf(copy)[static_cast<Eigen::Index>(i)];
      }
      keyframe.first_point += static_cast<std::uint64_t>(copy) * part.points.size();
      keyframes.push_back(keyframe);
    }
  }
  const std::vector<IndexRecord> index = MakeIndex(keyframes, part.info.index_cell_m);
  whole.info.length_m *= copies;
  whole.keyframes = keyframes;
  whole.index = index;
  whole.points = {};
  std::vector<std::byte> head = WriteMapFile(whole);  // its last section begins at its end
  MapFileHeader header;
  std::memcpy(&header, head.data(), sizeof(header));
  SectionEntry& points = header.sections[static_cast<std::size_t>(MapSection::kPoints)];
  points.size_bytes = static_cast<std::uint64_t>(copies) * part.points.size_bytes();
  header.file_size_bytes = points.offset_bytes + points.size_bytes;
  head.resize(points.offset_bytes);
  // The checksum of the points is left out: opening does not ask for it.
  header.crc32 = Crc32(std::as_bytes(std::span(&header, 1)).first(offsetof(MapFileHeader, crc32)));
  std::memcpy(head.data(), &header, sizeof(header));
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(head.data()), static_cast<std::streamsize>(head.size()));
  for (int copy = 0; copy < copies; ++copy) {
    file.write(reinterpret_cast<const char*>(part.points.data()),
               static_cast<std::streamsize>(part.points.size_bytes()));
  }
  return header.file_size_bytes;
}

double ResidentMegabytes() {
  std::ifstream statm("/proc/self/statm");
  double total_pages = 0.0;
  double resident_pages = 0.0;
  statm >> total_pages >> resident_pages;
  return 1e-6 * resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE));
}

struct Fleet {
  double scan_ms = 0.0;      ///< median of all scans of all vehicles
  double session_kb = 0.0;   ///< of memory, mean
  double resident_mb = 0.0;  ///< of the process, more than before the map was opened
  double error_m = 0.0;      ///< median
};

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Vehicles spread over the copies, all driving at once. The workspace is lent, as the server lends
// it: it is no part of a session.
Fleet DriveFleet(const std::shared_ptr<const RadarMap>& map, const Case& drives, int copies,
                 std::size_t scan_count, double resident_before_mb) {
  Fleet fleet;
  LocalizerWorkspace workspace;
  std::vector<Localizer> localizers;
  std::vector<Eigen::Vector3d> offsets_m;
  const auto allocated_before = static_cast<double>(mallinfo2().uordblks);
  for (int vehicle = 0; vehicle < kVehicles; ++vehicle) {
    offsets_m.push_back(OffsetOf(vehicle * copies / kVehicles));
    Pose3 start = drives.live_drive.scans.front().T_map_vehicle;
    start.translation_m += offsets_m.back();
    Vector6d sigmas;
    sigmas << 0.3, 0.3, 0.1, 0.01, 0.01, 0.02;
    localizers.push_back(*Localizer::Create(map, drives.live_drive.rig,
                                            InitialPose{start, sigmas.cwiseAbs2().asDiagonal()}));
  }
  std::vector<double> times_ms;
  std::vector<double> errors_m;
  for (std::size_t i = 0; i < std::min(scan_count, drives.live_drive.scans.size()); ++i) {
    const auto& [scan, T_map_vehicle] = drives.live_drive.scans[i];
    for (std::size_t vehicle = 0; vehicle < localizers.size(); ++vehicle) {
      const double begin_ms = CpuMilliseconds();
      const auto answer = localizers[vehicle].Localize(scan, workspace);
      const double scan_ms = CpuMilliseconds() - begin_ms;
      if (answer->state != LocalizationState::kTracking) continue;
      times_ms.push_back(scan_ms);
      errors_m.push_back(
          (answer->T_map_vehicle.translation_m - T_map_vehicle.translation_m - offsets_m[vehicle])
              .head<2>()
              .norm());
    }
  }
  fleet.scan_ms = Median(times_ms);
  fleet.error_m = Median(errors_m);
  fleet.resident_mb = ResidentMegabytes() - resident_before_mb;
  fleet.session_kb =
      (static_cast<double>(mallinfo2().uordblks) - allocated_before) / 1e3 / kVehicles;
  return fleet;
}

void Measure(const Case& drives, int copies, std::size_t scan_count) {
  const std::filesystem::path path = std::filesystem::temp_directory_path() /
                                     ("dcloc_large_" + std::to_string(getpid()) + ".dclm");
  const std::uint64_t size_bytes = WriteCopies(*drives.map, copies, path);
  malloc_trim(0);
  const double resident_before_mb = ResidentMegabytes();
  const auto begin = std::chrono::steady_clock::now();
  const auto map = RadarMap::Open(path);
  const double open_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  std::filesystem::remove(path);  // stays readable while it is mapped
  if (!map.ok()) {
    std::fprintf(stderr, "%s\n", map.status().ToString().c_str());
    std::exit(1);
  }
  const double length_km = (*map)->info().length_m / 1e3;
  const Fleet fleet = DriveFleet(*map, drives, copies, scan_count, resident_before_mb);
  std::printf("%9.1f %9.0f %9.3f %9.2f %9.1f %9.0f %9.3f %9.3f\n", length_km,
              1e-6 * static_cast<double>(size_bytes),
              1e-6 * static_cast<double>(size_bytes) / length_km, open_ms, fleet.resident_mb,
              fleet.session_kb, fleet.scan_ms, fleet.error_m);
}

}  // namespace
}  // namespace dcloc::benchmarks

int main(int argc, char** argv) {
  using namespace dcloc::benchmarks;  // NOLINT(google-build-using-namespace)
  const bool smoke = IsSmokeRun(argc, argv);
  const Case drives = SimulatedCase("ars408", smoke ? 60.0 : 1000.0);
  std::printf("%9s %9s %9s %9s %9s %9s %9s %9s\n", "street", "file", "file", "open", "resident",
              "session", "scan", "error");
  std::printf("%9s %9s %9s %9s %9s %9s %9s %9s\n", "km", "MB", "MB/km", "ms", "MB", "kB", "p50 ms",
              "p50 m");
  for (const int copies : smoke ? std::vector{1, 20} : std::vector{1, 100, 1000}) {
    Measure(drives, copies, smoke ? 40 : 300);
  }
  return 0;
}
