#include "client/datasets/files/radar_pcd.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <string>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/string_view.h"
#include "client/datasets/files/file_error.h"

namespace dcloc {
namespace {

// More than any radar sends; a header that claims more is broken, and is not given the memory.
constexpr std::uint64_t kMaxPoints = 1'000'000;
constexpr std::size_t kMaxPointBytes = 4096;

struct Field {
  std::string name;
  char type = ' ';  // F, I or U
  std::size_t size_bytes = 0;
  std::size_t offset_bytes = 0;
};

struct Layout {
  std::vector<Field> fields;
  std::size_t point_bytes = 0;
  std::size_t point_count = 0;
  std::size_t data_offset = 0;
};

using HeaderLines = std::map<absl::string_view, std::vector<absl::string_view>>;

absl::StatusOr<std::string> ReadWhole(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return CannotOpen(path);
  std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (file.bad()) return FileError(path, "cannot be read to its end");
  return bytes;
}

// The words of each header line by their keyword, and where the data begin.
absl::StatusOr<std::pair<HeaderLines, std::size_t>> SplitHeader(absl::string_view bytes) {
  HeaderLines lines;
  std::size_t begin = 0;
  while (!lines.contains("DATA")) {
    const std::size_t end = bytes.find('\n', begin);
    if (end == absl::string_view::npos) return absl::DataLossError("the header has no DATA line");
    const absl::string_view line = bytes.substr(begin, end - begin);
    begin = end + 1;
    std::vector<absl::string_view> words =
        absl::StrSplit(line, absl::ByAnyChar(" \t\r"), absl::SkipEmpty());
    if (words.empty() || words[0].front() == '#') continue;
    const absl::string_view keyword = words[0];
    words.erase(words.begin());
    if (!lines.emplace(keyword, std::move(words)).second) {
      return absl::DataLossError(absl::StrCat("the header has two ", keyword, " lines"));
    }
  }
  return std::pair{std::move(lines), begin};
}

absl::StatusOr<std::uint64_t> HeaderNumber(const HeaderLines& lines, absl::string_view keyword,
                                           std::uint64_t max) {
  const auto line = lines.find(keyword);
  std::uint64_t value = 0;
  if (line == lines.end() || line->second.size() != 1 ||
      !absl::SimpleAtoi(line->second[0], &value) || value > max) {
    return absl::DataLossError(
        absl::StrCat("the header's ", keyword, " line must hold one number in [0, ", max, "]"));
  }
  return value;
}

absl::StatusOr<std::vector<absl::string_view>> HeaderWords(const HeaderLines& lines,
                                                           absl::string_view keyword,
                                                           std::optional<std::size_t> count) {
  const auto line = lines.find(keyword);
  if (line == lines.end() || line->second.empty()) {
    return absl::DataLossError(absl::StrCat("the header has no ", keyword, " line"));
  }
  if (count.has_value() && line->second.size() != *count) {
    return absl::DataLossError(absl::StrCat("the header's ", keyword, " line has ",
                                            line->second.size(), " entries for ", *count,
                                            " fields"));
  }
  return line->second;
}

absl::Status AddFields(const HeaderLines& lines, Layout& layout) {
  const auto names = HeaderWords(lines, "FIELDS", std::nullopt);
  if (!names.ok()) return names.status();
  const auto sizes = HeaderWords(lines, "SIZE", names->size());
  if (!sizes.ok()) return sizes.status();
  const auto types = HeaderWords(lines, "TYPE", names->size());
  if (!types.ok()) return types.status();
  const auto counts = HeaderWords(lines, "COUNT", names->size());
  if (!counts.ok()) return counts.status();
  for (std::size_t i = 0; i < names->size(); ++i) {
    std::size_t size = 0;
    std::size_t count = 0;
    if (!absl::SimpleAtoi((*sizes)[i], &size) || size == 0 || size > 8 ||
        !absl::SimpleAtoi((*counts)[i], &count) || count == 0 || count > kMaxPointBytes) {
      return absl::DataLossError(absl::StrCat("the header gives field ", (*names)[i], " size ",
                                              (*sizes)[i], " and count ", (*counts)[i]));
    }
    layout.fields.push_back(
        {std::string((*names)[i]), (*types)[i][0], size * count, layout.point_bytes});
    layout.point_bytes += size * count;
    if (layout.point_bytes > kMaxPointBytes) {
      return absl::DataLossError(
          absl::StrCat("the header's points are larger than ", kMaxPointBytes, " bytes"));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<Layout> ReadLayout(absl::string_view bytes) {
  const auto header = SplitHeader(bytes);
  if (!header.ok()) return header.status();
  const HeaderLines& lines = header->first;
  if (lines.at("DATA") != std::vector<absl::string_view>{"binary"}) {
    return absl::DataLossError("the header's DATA line must say binary");
  }
  Layout layout;
  layout.data_offset = header->second;
  if (absl::Status status = AddFields(lines, layout); !status.ok()) return status;
  const auto width = HeaderNumber(lines, "WIDTH", kMaxPoints);
  if (!width.ok()) return width.status();
  const auto height = HeaderNumber(lines, "HEIGHT", kMaxPoints);
  if (!height.ok()) return height.status();
  const auto points = HeaderNumber(lines, "POINTS", kMaxPoints);
  if (!points.ok()) return points.status();
  if (*width * *height != *points) {
    return absl::DataLossError(absl::StrCat("the header says WIDTH ", *width, ", HEIGHT ", *height,
                                            " and POINTS ", *points));
  }
  layout.point_count = *points;
  const std::size_t have = bytes.size() - layout.data_offset;
  const std::size_t want = layout.point_count * layout.point_bytes;
  if (have < want) {
    return absl::DataLossError(absl::StrCat("is truncated: ", layout.point_count, " points of ",
                                            layout.point_bytes, " bytes need ", want,
                                            " bytes after the header, there are ", have));
  }
  return layout;
}

// Where a needed field lies in a point; it must have the type and size of the official files.
absl::StatusOr<std::size_t> Offset(const Layout& layout, absl::string_view name, char type,
                                   std::size_t size_bytes) {
  for (const Field& field : layout.fields) {
    if (field.name != name) continue;
    if (field.type == type && field.size_bytes == size_bytes) return field.offset_bytes;
    return absl::DataLossError(absl::StrCat("field ", name, " must have type ",
                                            std::string(1, type), " and size ", size_bytes));
  }
  return absl::DataLossError(absl::StrCat("has no field ", name));
}

constexpr std::array kFloatFields = {"x", "y", "z", "rcs", "vx", "vy"};
constexpr std::array kCodeFields = {"dyn_prop", "ambig_state", "invalid_state"};

struct Offsets {
  std::array<std::size_t, kFloatFields.size()> floats{};
  std::array<std::size_t, kCodeFields.size()> codes{};
};

absl::StatusOr<Offsets> FindOffsets(const Layout& layout) {
  Offsets offsets;
  for (std::size_t i = 0; i < kFloatFields.size(); ++i) {
    const auto offset = Offset(layout, kFloatFields[i], 'F', sizeof(float));
    if (!offset.ok()) return offset.status();
    offsets.floats[i] = *offset;
  }
  for (std::size_t i = 0; i < kCodeFields.size(); ++i) {
    const auto offset = Offset(layout, kCodeFields[i], 'I', sizeof(std::int8_t));
    if (!offset.ok()) return offset.status();
    offsets.codes[i] = *offset;
  }
  return offsets;
}

RadarPcdTarget ReadTarget(const char* point, const Offsets& offsets) {
  const auto number = [&](std::size_t i) {
    float value = 0.0F;
    std::memcpy(&value, point + offsets.floats[i], sizeof(value));
    return value;
  };
  const auto code = [&](std::size_t i) {
    return static_cast<int>(static_cast<std::int8_t>(point[offsets.codes[i]]));
  };
  return {number(0), number(1), number(2), number(3), number(4),
          number(5), code(0),   code(1),   code(2)};
}

bool HasNan(const RadarPcdTarget& target) {
  return std::isnan(target.x_m) || std::isnan(target.y_m) || std::isnan(target.z_m) ||
         std::isnan(target.rcs_dbsm) || std::isnan(target.vx_mps) || std::isnan(target.vy_mps);
}

}  // namespace

absl::StatusOr<std::vector<RadarPcdTarget>> ReadRadarPcd(const std::filesystem::path& path) {
  const auto bytes = ReadWhole(path);
  if (!bytes.ok()) return bytes.status();
  const auto layout = ReadLayout(*bytes);
  if (!layout.ok()) return FileError(path, layout.status().message());
  const auto offsets = FindOffsets(*layout);
  if (!offsets.ok()) return FileError(path, offsets.status().message());

  std::vector<RadarPcdTarget> targets;
  targets.reserve(layout->point_count);
  const char* point = bytes->data() + layout->data_offset;
  for (std::size_t i = 0; i < layout->point_count; ++i, point += layout->point_bytes) {
    const RadarPcdTarget target = ReadTarget(point, *offsets);
    if (!HasNan(target)) targets.push_back(target);
  }
  return targets;
}

}  // namespace dcloc
