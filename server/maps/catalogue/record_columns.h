#pragma once

#include <Eigen/Core>
#include <chrono>
#include <optional>

#include "core/geometry/geodetic_anchor.h"
#include "server/base/clock.h"
#include "server/maps/catalogue/catalogue.h"
#include "server/maps/catalogue/coverage.h"

namespace dcloc::server {

// Values of several columns, in the order in which every database of the catalogue has them. A
// `Row` gives its columns one after the other, an `Insert` takes them so: SqliteStatement, or
// PostgresRows and PostgresValues.

/// Columns x, y, z.
template <typename Row>
Eigen::Vector3d NextVector(Row& row) {
  const double x = row.NextReal();
  const double y = row.NextReal();
  const double z = row.NextReal();
  return {x, y, z};
}

template <typename Insert>
void BindVector(const Eigen::Vector3d& vector, Insert* insert) {
  insert->Bind(vector.x()).Bind(vector.y()).Bind(vector.z());
}

/// Columns latitude, longitude, height, direction of the x axis; all null without an anchor.
template <typename Row>
std::optional<GeodeticAnchor> NextAnchor(Row& row) {
  const bool present = !row.NextIsNull();
  GeodeticAnchor anchor;
  anchor.origin.latitude_deg = row.NextReal();
  anchor.origin.longitude_deg = row.NextReal();
  anchor.origin.height_m = row.NextReal();
  anchor.x_axis_east_rad = row.NextReal();
  return present ? std::optional(anchor) : std::nullopt;
}

template <typename Insert>
void BindAnchor(const std::optional<GeodeticAnchor>& anchor, Insert* insert) {
  if (anchor) {
    insert->Bind(anchor->origin.latitude_deg)
        .Bind(anchor->origin.longitude_deg)
        .Bind(anchor->origin.height_m)
        .Bind(anchor->x_axis_east_rad);
  } else {
    insert->BindNull().BindNull().BindNull().BindNull();
  }
}

/// Columns min x, max x, min y, max y.
template <typename Row>
Rectangle NextRectangle(Row& row) {
  Rectangle rectangle;
  rectangle.min_x = row.NextReal();
  rectangle.max_x = row.NextReal();
  rectangle.min_y = row.NextReal();
  rectangle.max_y = row.NextReal();
  return rectangle;
}

/// A column of nanoseconds since the epoch.
template <typename Row>
SystemTime NextTime(Row& row) {
  return SystemTime(std::chrono::nanoseconds(row.NextInteger()));
}

/// The columns of a map.
template <typename Row>
MapRecord NextMap(Row& row) {
  MapRecord record;
  record.name = row.NextText();
  record.active_version = row.NextInteger();
  record.version_count = static_cast<int>(row.NextInteger());
  record.create_time = NextTime(row);
  record.previous_version = row.NextInteger();
  record.canary_version = row.NextInteger();
  record.canary_share = row.NextReal();
  return record;
}

}  // namespace dcloc::server
