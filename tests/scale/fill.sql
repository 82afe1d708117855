-- A catalogue of many tenants: the versions of the map "seed" of tenant "t1" are copied to each map of
-- each tenant. :tenants, :maps (of a tenant) and :holders are given to psql.
\set ON_ERROR_STOP
SET search_path = dcloc, public;
SET session_replication_role = replica;  -- without triggers: no server is to read all of it again

INSERT INTO map (name, active_version, next_version, create_time_ns)
SELECT 't' || t || '/map-' || m, seed.active_version, seed.next_version, seed.create_time_ns
FROM generate_series(1, :tenants) AS t, generate_series(1, :maps) AS m,
     (SELECT * FROM map WHERE name = 't1/seed') AS seed;

INSERT INTO map_version (
  map_name, version, sha256, create_time_ns, size_bytes, drive_name, description, keyframe_count,
  point_count, length_m, min_x_m, min_y_m, min_z_m, max_x_m, max_y_m, max_z_m, has_elevation)
SELECT map.name, v.version, v.sha256, v.create_time_ns, v.size_bytes, v.drive_name, v.description,
       v.keyframe_count, v.point_count, v.length_m, v.min_x_m, v.min_y_m, v.min_z_m, v.max_x_m,
       v.max_y_m, v.max_z_m, v.has_elevation
FROM map, map_version AS v
WHERE v.map_name = 't1/seed' AND map.name <> 't1/seed';

-- A street of each version, on a grid of 0.1 degrees on the Earth.
INSERT INTO coverage_box
SELECT map_name, version, min_x_m, max_x_m, min_y_m, max_y_m, longitude, longitude + 0.01, latitude,
       latitude + 0.01
FROM (SELECT *, (hash % 3600) / 10.0 - 180.0 AS longitude, (hash / 3600 % 1600) / 10.0 - 80.0 AS latitude
      FROM (SELECT *, abs(hashtext(map_name)) AS hash FROM map_version
            WHERE map_name <> 't1/seed') AS hashed) AS placed;

INSERT INTO holder
SELECT 'holder-' || h, clock_timestamp() + interval '1 day' FROM generate_series(1, :holders) AS h;
-- Each holder has sessions in a thousand maps.
INSERT INTO version_hold (holder, map_name, version)
SELECT 'holder-' || h, name, active_version
FROM generate_series(1, :holders) AS h,
     (SELECT name, active_version FROM map WHERE name <> 't1/seed' ORDER BY hashtext(name) LIMIT 1000)
       AS used;
ANALYZE;
SELECT 'maps', count(*) FROM map UNION ALL SELECT 'versions', count(*) FROM map_version
UNION ALL SELECT 'holds', count(*) FROM version_hold
UNION ALL SELECT 'MiB', pg_database_size(current_database()) / 1048576;
