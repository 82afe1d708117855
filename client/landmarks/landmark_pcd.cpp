#include "client/landmarks/landmark_pcd.h"

#include <cstdint>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/landmarks/pcd_table.h"
#include "client/landmarks/point_fields.h"

namespace dcloc {
namespace {

constexpr std::array kPositionFields = {"x", "y", "z"};

template <typename T>
void AppendValue(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

std::string HeaderText(const EditableMap& map, std::size_t point_count) {
  std::string fields = "FIELDS x y z";
  std::string sizes = "SIZE 4 4 4";
  std::string types = "TYPE F F F";
  std::string counts = "COUNT 1 1 1";
  const auto add = [&](const char* name, int size_bytes, char type) {
    absl::StrAppend(&fields, " ", name);
    absl::StrAppend(&sizes, " ", size_bytes);
    absl::StrAppendFormat(&types, " %c", type);
    absl::StrAppend(&counts, " 1");
  };
  for (const PointField& field : kPointFields) add(field.name, 4, 'F');
  for (const CountField& field : kCountFields) add(field.name, 2, 'U');
  add("keyframe", 4, 'U');
  const Eigen::Vector3d origin_m = map.Origin_m();
  return absl::StrFormat(
      "# .PCD v0.7 - Point Cloud Data file format\n"
      "# dcloc landmarks; x, y, z relative to (%.17g, %.17g, %.17g) m of the map frame\n"
      "VERSION 0.7\n%s\n%s\n%s\n%s\nWIDTH %d\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS %d\n"
      "DATA binary\n",
      origin_m.x(), origin_m.y(), origin_m.z(), fields, sizes, types, counts, point_count,
      point_count);
}

// A file's fields by their columns.
class RowReader {
 public:
  static absl::StatusOr<RowReader> Create(const PcdTable& table) {
    RowReader reader;
    reader.keyframe_ = table.ColumnOf("keyframe");
    reader.has_keyframe_ = reader.keyframe_ < table.fields.size();
    for (const char* name : kPositionFields) reader.position_.push_back(table.ColumnOf(name));
    for (const PointField& field : kPointFields) {
      reader.points_.push_back(table.ColumnOf(field.name));
    }
    for (const CountField& field : kCountFields) {
      reader.counts_.push_back(table.ColumnOf(field.name));
    }
    for (std::size_t i = 0; i < kPositionFields.size(); ++i) {
      if (reader.position_[i] == table.fields.size()) return Missing(kPositionFields[i]);
    }
    for (std::size_t i = reader.FirstPointField(); i < kPointFields.size(); ++i) {
      if (reader.points_[i] == table.fields.size()) return Missing(kPointFields[i].name);
    }
    for (std::size_t i = 0; i < kCountFields.size(); ++i) {
      if (reader.counts_[i] == table.fields.size()) return Missing(kCountFields[i].name);
    }
    return reader;
  }

  absl::Status Read(const std::vector<double>& values, LandmarkRow& row) const {
    for (std::size_t i = 0; i < position_.size(); ++i) {
      row.p_map(static_cast<Eigen::Index>(i)) = values[position_[i]];
    }
    if (has_keyframe_) {
      if (absl::Status status = CheckKeyframeNumber(values[keyframe_]); !status.ok()) return status;
      row.keyframe = static_cast<std::uint32_t>(values[keyframe_]);
    }
    absl::Status status;
    for (std::size_t i = FirstPointField(); i < points_.size(); ++i) {
      status.Update(SetField(kPointFields[i], values[points_[i]], row.point));
    }
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      status.Update(SetField(kCountFields[i], values[counts_[i]], row.point));
    }
    return status;
  }

 private:
  static absl::Status Missing(const char* name) {
    return absl::InvalidArgumentError(absl::StrCat("has no field ", name));
  }

  // The first three are a position in the keyframe.
  std::size_t FirstPointField() const { return has_keyframe_ ? 0 : 3; }

  std::vector<std::size_t> position_, points_, counts_;
  std::size_t keyframe_ = 0;
  bool has_keyframe_ = false;
};

}  // namespace

std::string FormatLandmarkPcd(const EditableMap& map) {
  const std::vector<LandmarkRow> rows = RowsOf(map);
  const Eigen::Vector3d origin_m = map.Origin_m();
  std::string bytes = HeaderText(map, rows.size());
  for (const LandmarkRow& row : rows) {
    for (const double value : Eigen::Vector3d(row.p_map - origin_m)) {
      AppendValue(bytes, static_cast<float>(value));
    }
    for (const PointField& field : kPointFields) AppendValue(bytes, row.point.*field.member);
    for (const CountField& field : kCountFields) AppendValue(bytes, row.point.*field.member);
    AppendValue(bytes, *row.keyframe);
  }
  return bytes;
}

absl::StatusOr<std::vector<LandmarkRow>> ParseLandmarkPcd(absl::string_view bytes,
                                                          absl::string_view name,
                                                          const Eigen::Vector3d& origin_m) {
  const auto named = [](absl::string_view where, const absl::Status& status) {
    return absl::Status(status.code(), absl::StrCat(where, ": ", status.message()));
  };
  const absl::StatusOr<PcdTable> table = ParsePcd(bytes);
  if (!table.ok()) return named(name, table.status());
  const absl::StatusOr<RowReader> reader = RowReader::Create(*table);
  if (!reader.ok()) return named(name, reader.status());
  std::vector<LandmarkRow> rows;
  rows.reserve(table->rows.size());
  for (const std::vector<double>& values : table->rows) {
    LandmarkRow row{.p_map = Eigen::Vector3d::Zero(),
                    .keyframe = {},
                    .point = {},
                    .name = absl::StrCat(name, ": point ", rows.size())};
    if (absl::Status status = reader->Read(values, row); !status.ok()) {
      return named(row.name, status);
    }
    row.p_map += origin_m;
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace dcloc
