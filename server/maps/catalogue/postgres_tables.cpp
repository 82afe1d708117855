#include "server/maps/catalogue/postgres_tables.h"

#include <chrono>

#include "server/maps/catalogue/record_columns.h"
#include "server/postgres/postgres_migrations.h"

namespace dcloc::server {
namespace {

/// Names sort by their bytes, as in SQLite. A map's tenant is the part of its name up to the slash.
constexpr char kCreateMaps[] = R"(
CREATE TABLE dcloc.map (
  name text COLLATE "C" PRIMARY KEY,
  tenant text COLLATE "C" NOT NULL GENERATED ALWAYS AS (left(name, strpos(name, '/'))) STORED,
  active_version bigint NOT NULL DEFAULT 0,
  next_version bigint NOT NULL,
  create_time_ns bigint NOT NULL,
  previous_version bigint NOT NULL DEFAULT 0,
  canary_version bigint NOT NULL DEFAULT 0,
  canary_share double precision NOT NULL DEFAULT 0
);
CREATE INDEX map_tenant ON dcloc.map (tenant, name);

CREATE TABLE dcloc.map_version (
  map_name text COLLATE "C" NOT NULL REFERENCES dcloc.map (name) ON DELETE CASCADE,
  version bigint NOT NULL,
  sha256 text COLLATE "C" NOT NULL,
  create_time_ns bigint NOT NULL,
  size_bytes bigint NOT NULL,
  drive_name bytea NOT NULL,
  description bytea NOT NULL,
  keyframe_count bigint NOT NULL,
  point_count bigint NOT NULL,
  length_m double precision NOT NULL,
  min_x_m double precision NOT NULL,
  min_y_m double precision NOT NULL,
  min_z_m double precision NOT NULL,
  max_x_m double precision NOT NULL,
  max_y_m double precision NOT NULL,
  max_z_m double precision NOT NULL,
  has_elevation boolean NOT NULL,
  anchor_latitude_deg double precision,
  anchor_longitude_deg double precision,
  anchor_height_m double precision,
  anchor_x_axis_east_rad double precision,
  tenant text COLLATE "C" NOT NULL
    GENERATED ALWAYS AS (left(map_name, strpos(map_name, '/'))) STORED,
  PRIMARY KEY (map_name, version),
  UNIQUE (map_name, sha256)
);
CREATE INDEX map_version_sha256 ON dcloc.map_version (sha256);
CREATE INDEX map_version_tenant ON dcloc.map_version (tenant, sha256);

CREATE VIEW dcloc.map_row AS
  SELECT name, active_version,
         (SELECT count(*) FROM dcloc.map_version WHERE map_name = name) AS version_count,
         create_time_ns, previous_version, canary_version, canary_share, tenant
  FROM dcloc.map;

CREATE VIEW dcloc.map_version_row AS
  SELECT map_name, version, sha256, v.create_time_ns, size_bytes, drive_name, description,
         keyframe_count, point_count, length_m, min_x_m, min_y_m, min_z_m, max_x_m, max_y_m,
         max_z_m, has_elevation, anchor_latitude_deg, anchor_longitude_deg, anchor_height_m,
         anchor_x_axis_east_rad, active_version = version AS active
  FROM dcloc.map_version AS v JOIN dcloc.map ON map_name = name;

CREATE TABLE dcloc.loose_file (sha256 text COLLATE "C" PRIMARY KEY);

CREATE CONSTRAINT TRIGGER map_change AFTER INSERT OR UPDATE OR DELETE ON dcloc.map
  DEFERRABLE INITIALLY DEFERRED FOR EACH ROW EXECUTE FUNCTION dcloc.note_change('catalogue');
CREATE CONSTRAINT TRIGGER map_version_change AFTER INSERT OR UPDATE OR DELETE ON dcloc.map_version
  DEFERRABLE INITIALLY DEFERRED FOR EACH ROW EXECUTE FUNCTION dcloc.note_change('catalogue');
)";

/// PostGIS compares 32-bit bounds, which it rounds outwards; the exact ones stand beside them.
constexpr char kCreateCoverageBoxes[] = R"(
DO $$ BEGIN
  IF NOT EXISTS (SELECT 1 FROM pg_extension WHERE extname = 'postgis') THEN
    CREATE EXTENSION postgis SCHEMA public;
  END IF;
END $$;

CREATE TABLE dcloc.coverage_box (
  map_name text COLLATE "C" NOT NULL,
  version bigint NOT NULL,
  min_x_m double precision NOT NULL,
  max_x_m double precision NOT NULL,
  min_y_m double precision NOT NULL,
  max_y_m double precision NOT NULL,
  min_longitude_deg double precision,
  max_longitude_deg double precision,
  min_latitude_deg double precision,
  max_latitude_deg double precision,
  on_map geometry NOT NULL
    GENERATED ALWAYS AS (ST_MakeEnvelope(min_x_m, min_y_m, max_x_m, max_y_m)) STORED,
  on_earth geometry GENERATED ALWAYS AS (ST_MakeEnvelope(
    min_longitude_deg, min_latitude_deg, max_longitude_deg, max_latitude_deg)) STORED,
  FOREIGN KEY (map_name, version) REFERENCES dcloc.map_version ON DELETE CASCADE
);
CREATE INDEX coverage_box_version ON dcloc.coverage_box (map_name, version);
CREATE INDEX coverage_box_on_earth ON dcloc.coverage_box USING gist (on_earth);
)";

/// A holder lives until its lease has ended by the database's clock. While the database was away
/// nobody could renew one, so after its start all live for the time of a lease.
constexpr char kCreateHolds[] = R"(
CREATE TABLE dcloc.holder (
  name text COLLATE "C" PRIMARY KEY,
  lease_end timestamptz NOT NULL
);
CREATE VIEW dcloc.live_holder AS
  SELECT name FROM dcloc.holder
  WHERE lease_end > clock_timestamp()
     OR pg_postmaster_start_time() > clock_timestamp() - interval '15 s';

CREATE TABLE dcloc.version_hold (
  holder text COLLATE "C" NOT NULL REFERENCES dcloc.holder ON DELETE CASCADE,
  map_name text COLLATE "C" NOT NULL,
  version bigint NOT NULL,
  PRIMARY KEY (map_name, version, holder),
  FOREIGN KEY (map_name, version) REFERENCES dcloc.map_version ON DELETE CASCADE
);
CREATE INDEX version_hold_holder ON dcloc.version_hold (holder);

CREATE TABLE dcloc.file_hold (
  sha256 text COLLATE "C" PRIMARY KEY,
  holder text COLLATE "C" NOT NULL REFERENCES dcloc.holder ON DELETE CASCADE,
  token bigint NOT NULL UNIQUE
);
CREATE INDEX file_hold_holder ON dcloc.file_hold (holder);
CREATE SEQUENCE dcloc.file_hold_token;
)";

constexpr const char* kSteps[] = {kCreateMaps, kCreateCoverageBoxes, kCreateHolds};
constexpr PostgresMigrations kMigrations{.part = "catalogue", .steps = kSteps};

}  // namespace

absl::Status PrepareTables(PostgresConnection& connection) {
  return Migrate(connection, kMigrations);
}

const char* const kInsertPostgresVersion =
    "INSERT INTO map_version VALUES ($1,$2,$3,$4,$5,$6,$7,$8,$9,$10,$11,$12,$13,$14,$15,$16,$17,"
    "$18,$19,$20,$21)";

MapRecord ReadMap(PostgresRows& row) { return NextMap(row); }

MapVersionRecord ReadVersion(PostgresRows& row) {
  MapVersionRecord record;
  record.map_name = row.NextText();
  record.version = row.NextInteger();
  record.sha256 = row.NextText();
  record.create_time = NextTime(row);
  record.info.size_bytes = static_cast<std::uint64_t>(row.NextInteger());
  record.info.name = row.NextBytes();
  record.info.description = row.NextBytes();
  record.info.keyframe_count = static_cast<std::uint64_t>(row.NextInteger());
  record.info.point_count = static_cast<std::uint64_t>(row.NextInteger());
  record.info.length_m = row.NextReal();
  record.info.min_map_m = NextVector(row);
  record.info.max_map_m = NextVector(row);
  record.info.has_elevation = row.NextBool();
  record.info.anchor = NextAnchor(row);
  record.active = row.NextBool();
  return record;
}

void BindVersion(const MapVersionRecord& record, PostgresValues* insert) {
  const MapInfo& info = record.info;
  insert->Bind(record.map_name)
      .Bind(record.version)
      .Bind(record.sha256)
      .Bind(std::int64_t{record.create_time.time_since_epoch().count()})
      .Bind(static_cast<std::int64_t>(info.size_bytes))
      .BindBytes(info.name)
      .BindBytes(info.description)
      .Bind(static_cast<std::int64_t>(info.keyframe_count))
      .Bind(static_cast<std::int64_t>(info.point_count))
      .Bind(info.length_m);
  BindVector(info.min_map_m, insert);
  BindVector(info.max_map_m, insert);
  insert->Bind(info.has_elevation);
  BindAnchor(info.anchor, insert);
}

}  // namespace dcloc::server
