#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/map/radar_map.h"

namespace dcloc {

// The records of a map file as they lie on disk and in memory; maps/FORMAT.md describes every byte.
static_assert(std::endian::native == std::endian::little, "map files are used in place");

inline constexpr std::array<char, 8> kMapFileMagic = {'D', 'C', 'L', 'O', 'C', 'M', 'A', 'P'};
inline constexpr std::uint32_t kMapFileVersion = 1;
inline constexpr std::size_t kSectionAlignment_bytes = 64;
inline constexpr std::size_t kMaxMapName_bytes = 256;
inline constexpr std::size_t kMaxMapDescription_bytes = 4096;
/// Keyframes lie this near to the local origin, and the local origin this near to the map's.
inline constexpr double kMaxLocal_m = 1e7;
inline constexpr double kMaxOrigin_m = 1e9;

/// The sections, in the file's order.
enum class MapSection : std::uint32_t { kInfo, kText, kKeyframes, kIndex, kPoints };
inline constexpr std::size_t kMapSectionCount = 5;
inline constexpr std::array<const char*, kMapSectionCount> kMapSectionNames = {
    "info", "text", "keyframes", "index", "points"};

struct SectionEntry {
  std::uint64_t offset_bytes;
  std::uint64_t size_bytes;
  std::uint32_t crc32;
  std::uint32_t zero;
};

struct MapFileHeader {
  std::array<char, 8> magic;
  std::uint32_t version;
  std::uint32_t section_count;
  std::uint64_t file_size_bytes;
  std::array<SectionEntry, kMapSectionCount> sections;
  std::array<std::uint32_t, 11> zero;
  std::uint32_t crc32;  ///< of all bytes of the header before it
};
static_assert(sizeof(MapFileHeader) == 192);

struct InfoRecord {
  std::array<double, 3> local_origin_m;  ///< of the keyframes' translations, in the map
  double length_m;
  double index_cell_m;
  double anchor_latitude_deg;
  double anchor_longitude_deg;
  double anchor_height_m;
  double anchor_x_axis_east_rad;
  std::uint32_t flags;
  std::uint32_t name_size_bytes;
};
static_assert(sizeof(InfoRecord) == 80);
inline constexpr std::uint32_t kHasElevationFlag = 1;
inline constexpr std::uint32_t kHasAnchorFlag = 2;
inline constexpr std::uint32_t kHasHeightsFlag = 4;
inline constexpr std::uint32_t kHasKnownStampsFlag = 8;
/// With kHasKnownStampsFlag: a delay [ms] as a signed number in the upper half of the flags.
inline constexpr int kStampDelayShift = 16;
inline constexpr double kMaxStampDelay_s = 1.0;

struct KeyframeRecord {
  std::array<double, 3> translation_local_m;
  std::array<double, 4> rotation_wxyz;
  std::uint64_t first_point;
  std::uint32_t point_count;
  std::uint32_t accuracy;  ///< of `PackAccuracy`; 0: not known
};
static_assert(sizeof(KeyframeRecord) == 72);

struct IndexRecord {
  std::int32_t cell_x;
  std::int32_t cell_y;
  std::uint32_t keyframe;
};
static_assert(sizeof(IndexRecord) == 12);

/// The parts of a map file, in place.
struct MapFileView {
  InfoRecord info;
  std::string_view name;
  std::string_view description;
  std::span<const KeyframeRecord> keyframes;
  std::span<const IndexRecord> index;
  std::span<const MapPoint> points;
};

/// Checks everything but the points and their checksum, in time that grows with the keyframes only:
/// all indices in the view are within bounds. DataLoss says what is wrong and where. `bytes` are
/// aligned to 8 and outlive the view.
absl::StatusOr<MapFileView> ParseMapFile(std::span<const std::byte> bytes);

/// Checks what `ParseMapFile` does not: the points, their checksum, and that all padding is zero.
/// `view` is the result of `ParseMapFile` for these `bytes`.
absl::Status VerifyMapFile(std::span<const std::byte> bytes, const MapFileView& view);

/// The bytes of a file with these parts.
std::vector<std::byte> WriteMapFile(const MapFileView& view);

/// CRC-32 as in zlib, over any length.
std::uint32_t Crc32(std::span<const std::byte> bytes);

/// Where the section after one that ends at `end_bytes` begins.
constexpr std::uint64_t AlignSection(std::uint64_t end_bytes) {
  return (end_bytes + kSectionAlignment_bytes - 1) / kSectionAlignment_bytes *
         kSectionAlignment_bytes;
}

}  // namespace dcloc
