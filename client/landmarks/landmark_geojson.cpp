#include "client/landmarks/landmark_geojson.h"

#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/landmarks/geojson_text.h"
#include "client/landmarks/point_fields.h"

namespace dcloc {
namespace {

using Json = nlohmann::json;

std::string FeatureOf(const LandmarkRow& row, const GeodeticAnchor& anchor) {
  const GeodeticPosition p = GeodeticFromMap(anchor, row.p_map);
  std::string text = absl::StrFormat(
      R"({"type":"Feature","geometry":{"type":"Point","coordinates":[%.9f,%.9f,%.4f]},)"
      R"("properties":{"keyframe":%d)",
      p.longitude_deg, p.latitude_deg, p.height_m, *row.keyframe);
  for (const PointField& field : kPointFields) {
    absl::StrAppendFormat(&text, R"(,"%s":%.9g)", field.name, row.point.*field.member);
  }
  for (const CountField& field : kCountFields) {
    absl::StrAppendFormat(&text, R"(,"%s":%d)", field.name, row.point.*field.member);
  }
  return text + "}}";
}

absl::Status ReadPosition(const Json& feature, const GeodeticAnchor& anchor, LandmarkRow& row) {
  const Json& geometry = MemberOf(feature, "geometry");
  if (MemberOf(geometry, "type") != "Point") {
    return absl::InvalidArgumentError("geometry is no Point");
  }
  const Json& coordinates = MemberOf(geometry, "coordinates");
  const bool is_position = coordinates.is_array() && coordinates.size() >= 2 &&
                           coordinates.size() <= 3 && coordinates.front().is_number() &&
                           coordinates[1].is_number() && coordinates.back().is_number();
  if (!is_position) {
    return absl::InvalidArgumentError(
        "coordinates must be 2 or 3 numbers: longitude, latitude "
        "and height");
  }
  GeodeticPosition position{.latitude_deg = coordinates[1].get<double>(),
                            .longitude_deg = coordinates[0].get<double>(),
                            .height_m = anchor.origin.height_m};
  row.has_height = coordinates.size() > 2;
  if (row.has_height) position.height_m = coordinates[2].get<double>();
  if (absl::Status status = Validate(position); !status.ok()) return status;
  row.p_map = MapFromGeodetic(anchor, position);
  return absl::OkStatus();
}

absl::StatusOr<double> NumberOf(const Json& properties, const char* name) {
  const auto value = properties.find(name);
  if (value == properties.end() || value->is_null()) {
    return absl::InvalidArgumentError(absl::StrFormat("has no property %s", name));
  }
  if (value->is_number()) return value->get<double>();
  return absl::InvalidArgumentError(
      absl::StrFormat("%s is %s; it must be a number", name,
                      value->dump(-1, ' ', false, Json::error_handler_t::replace).substr(0, 40)));
}

absl::Status ReadProperties(const Json& properties, LandmarkRow& row) {
  if (properties.contains("keyframe") && !properties["keyframe"].is_null()) {
    const absl::StatusOr<double> number = NumberOf(properties, "keyframe");
    if (!number.ok()) return number.status();
    if (absl::Status status = CheckKeyframeNumber(*number); !status.ok()) return status;
    row.keyframe = static_cast<std::uint32_t>(*number);
  }
  const auto read = [&](const auto& field) -> absl::Status {
    const absl::StatusOr<double> number = NumberOf(properties, field.name);
    return number.ok() ? SetField(field, *number, row.point) : number.status();
  };
  for (std::size_t i = row.keyframe ? 0 : 3; i < kPointFields.size(); ++i) {
    // Without a keyframe there is no position in it.
    if (absl::Status status = read(kPointFields[i]); !status.ok()) return status;
  }
  for (const CountField& field : kCountFields) {
    if (absl::Status status = read(field); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status ReadFeature(const Json& feature, const GeodeticAnchor& anchor, LandmarkRow& row) {
  if (!feature.is_object()) return absl::InvalidArgumentError("is no object");
  if (absl::Status status = ReadPosition(feature, anchor, row); !status.ok()) return status;
  const auto properties = feature.find("properties");
  if (properties == feature.end() || !properties->is_object()) {
    return absl::InvalidArgumentError("has no properties");
  }
  return ReadProperties(*properties, row);
}

}  // namespace

absl::StatusOr<std::string> FormatLandmarkGeoJson(const EditableMap& map) {
  const std::optional<GeodeticAnchor> anchor = map.Anchor();
  if (!anchor) {
    return absl::FailedPreconditionError(absl::StrCat(
        "map ", map.name,
        ": GeoJSON has places on the Earth, and the map has no anchor; write PCD, or give the map "
        "an anchor"));
  }
  std::string text = "{\"type\":\"FeatureCollection\",\"features\":[";
  const char* separator = "\n";
  for (const LandmarkRow& row : RowsOf(map)) {
    absl::StrAppend(&text, separator, FeatureOf(row, *anchor));
    separator = ",\n";
  }
  return text + "\n]}\n";
}

absl::StatusOr<std::vector<LandmarkRow>> ParseLandmarkGeoJson(absl::string_view text,
                                                              absl::string_view name,
                                                              const GeodeticAnchor& anchor) {
  const absl::StatusOr<Json> json = ParseGeoJson(text, name);
  if (!json.ok()) return json.status();
  const Json& features = MemberOf(*json, "features");
  if (MemberOf(*json, "type") != "FeatureCollection" || !features.is_array()) {
    return absl::DataLossError(absl::StrCat(name, ": is no FeatureCollection of GeoJSON"));
  }
  std::vector<LandmarkRow> rows;
  for (const Json& feature : features) {
    LandmarkRow row{.p_map = Eigen::Vector3d::Zero(),
                    .keyframe = {},
                    .point = {},
                    .name = absl::StrCat(name, ": feature ", rows.size())};
    if (absl::Status status = ReadFeature(feature, anchor, row); !status.ok()) {
      return absl::Status(status.code(), absl::StrCat(row.name, ": ", status.message()));
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace dcloc
