#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <vector>

#include "core/map/map_file.h"
#include "core/map/radar_map.h"
#include "tests/core/map/synthetic_map.h"
#include "tests/fuzz/fuzz_target.h"

namespace dcloc {
namespace {

// Makes the checksums right, where the frame still allows it: without this nearly every input dies
// at the first checksum, and the checks behind it stay untried.
void RepairChecksums(std::span<std::byte> bytes) {
  if (bytes.size() < sizeof(MapFileHeader)) return;
  MapFileHeader header{};
  std::memcpy(&header, bytes.data(), sizeof(header));
  for (SectionEntry& section : header.sections) {
    if (section.offset_bytes > bytes.size()) continue;
    if (section.size_bytes > bytes.size() - section.offset_bytes) continue;
    section.crc32 = Crc32(bytes.subspan(section.offset_bytes, section.size_bytes));
  }
  header.crc32 = Crc32(std::as_bytes(std::span(&header, 1)).first(offsetof(MapFileHeader, crc32)));
  std::memcpy(bytes.data(), &header, sizeof(header));
}

// Touches all that a map gives; the sanitizers say whether it is ours to touch.
void UseMap(std::vector<std::byte> bytes) {
  const auto map = RadarMap::FromBytes(std::move(bytes));
  if (!map.ok()) return;
  const MapInfo& info = (*map)->info();
  float sum = 0.0F;
  for (std::size_t i = 0; i < info.keyframe_count; ++i) {
    for (const MapPoint& point : (*map)->keyframe(i).points) sum += point.x_m + point.rcs_dbsm;
  }
  for (const Eigen::Vector3d& p_map :
       {info.min_map_m, info.max_map_m, Eigen::Vector3d(1e9, 0, 0)}) {
    for (const double reach_m : {0.0, 50.0, 1e7, std::numeric_limits<double>::infinity()}) {
      sum += static_cast<float>((*map)->KeyframesWithin(p_map, reach_m).size());
      sum += static_cast<float>((*map)->NearestKeyframe(p_map, reach_m).value_or(0));
    }
  }
  volatile float used = sum;
  static_cast<void>(used);
  static_cast<void>((*map)->Verify());
}

}  // namespace

std::vector<FuzzInput> FuzzSeeds() {
  std::vector<FuzzInput> seeds;
  for (const std::size_t keyframe_count : {0U, 1U, 12U}) {
    const std::vector<std::byte> bytes = SyntheticMap(keyframe_count, 5).Bytes();
    const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
    seeds.emplace_back(data, data + bytes.size());
  }
  return seeds;
}

}  // namespace dcloc

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto* begin = reinterpret_cast<const std::byte*>(data);
  std::vector<std::byte> bytes(begin, begin + size);
  dcloc::UseMap(bytes);
  dcloc::RepairChecksums(bytes);
  dcloc::UseMap(std::move(bytes));
  return 0;
}
