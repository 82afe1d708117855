#include "client/cli/map/map_exchange_command.h"

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/common/exit_codes.h"
#include "client/cli/common/input_file.h"
#include "client/cli/common/output_file.h"
#include "client/cli/common/terminal.h"
#include "client/cli/common/trajectory_options.h"
#include "client/cli/map/map_files.h"
#include "client/cli/map/map_report.h"
#include "client/landmarks/keyframe_trajectory.h"
#include "client/landmarks/landmark_geojson.h"
#include "client/landmarks/landmark_pcd.h"
#include "client/trajectory/trajectory_reader.h"
#include "client/trajectory/trajectory_writer.h"

namespace dcloc::cli {
namespace {

using nlohmann::ordered_json;

struct ExportArguments {
  std::string file;
  std::string landmarks;
  TrajectoryArguments trajectory;
  bool force = false;
  bool json = false;
};

struct ImportArguments {
  std::string base;
  std::string landmarks;
  std::string trajectory;
  std::string name;
  std::string out;
  bool force = false;
  bool json = false;
};

bool IsPcd(const std::string& file) { return absl::EndsWithIgnoreCase(file, ".pcd"); }

std::string CheckLandmarkFile(const std::string& file) {
  const bool is_known = IsPcd(file) || absl::EndsWithIgnoreCase(file, ".geojson") ||
                        absl::EndsWithIgnoreCase(file, ".json");
  return is_known ? "" : "must end with .pcd, .geojson or .json";
}

void PrintJson(const ordered_json& json) {
  absl::PrintF("%s\n", json.dump(2, ' ', false, ordered_json::error_handler_t::replace));
}

absl::Status AddMadeFile(const std::string& file, const absl::StatusOr<std::string>& text,
                         std::vector<MadeFile>& made) {
  if (!text.ok()) return text.status();
  const auto bytes = std::as_bytes(std::span(*text));
  made.push_back({file, {bytes.begin(), bytes.end()}});
  return absl::OkStatus();
}

// `CheckTrajectory` has passed it.
absl::StatusOr<std::string> KeyframeText(const TrajectoryArguments& arguments,
                                         const EditableMap& map) {
  const auto format = TrajectoryFormatOf(arguments.file, arguments.format);
  if (!format.ok()) return format.status();
  return FormatTrajectory(KeyframeTrajectory(map), *format);
}

absl::Status Export(const ExportArguments& arguments) {
  absl::Status status =
      CheckOutputFiles({{arguments.landmarks, arguments.trajectory.file}, arguments.force});
  if (!status.ok()) return status;
  const absl::StatusOr<EditableMap> map = ReadMapParts(arguments.file);
  if (!map.ok()) return map.status();
  status = CheckTrajectory(arguments.trajectory, map->Anchor().has_value());
  // Both before one is written, so that an error leaves no half of an export.
  std::vector<MadeFile> made;
  if (status.ok() && !arguments.landmarks.empty()) {
    const bool is_pcd = IsPcd(arguments.landmarks);
    status = AddMadeFile(arguments.landmarks,
                         is_pcd ? FormatLandmarkPcd(*map) : FormatLandmarkGeoJson(*map), made);
  }
  if (status.ok() && !arguments.trajectory.file.empty()) {
    status = AddMadeFile(arguments.trajectory.file, KeyframeText(arguments.trajectory, *map), made);
  }
  if (status.ok()) status = WriteMadeFiles(made, arguments.force);
  if (!status.ok()) return status;
  if (arguments.json) {
    PrintJson({{"landmarks", arguments.landmarks},
               {"landmark_count", map->PointCount()},
               {"trajectory", arguments.trajectory.file},
               {"keyframe_count", map->keyframes.size()}});
    return absl::OkStatus();
  }
  if (!arguments.landmarks.empty()) {
    absl::PrintF("%s: %d landmarks\n", Visible(arguments.landmarks), map->PointCount());
  }
  if (!arguments.trajectory.file.empty()) {
    absl::PrintF("%s: %d keyframes\n", Visible(arguments.trajectory.file), map->keyframes.size());
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<LandmarkRow>> ReadLandmarks(const std::string& file,
                                                       const EditableMap& base) {
  const absl::StatusOr<std::string> text = ReadInputFile(file);
  if (!text.ok()) return text.status();
  if (IsPcd(file)) return ParseLandmarkPcd(*text, file, base.Origin_m());
  const std::optional<GeodeticAnchor> anchor = base.Anchor();
  if (!anchor) {
    return absl::FailedPreconditionError(
        absl::StrCat(file, ": has places on the Earth, and the base map has no anchor"));
  }
  return ParseLandmarkGeoJson(*text, file, *anchor);
}

// The files one after the other: landmarks where the base's keyframes have them, then keyframes.
absl::StatusOr<EditableMap> WithLandmarksOf(const ImportArguments& arguments, EditableMap map,
                                            LandmarkEdits& counts,
                                            std::size_t& moved_keyframe_count) {
  if (!arguments.landmarks.empty()) {
    const absl::StatusOr<std::vector<LandmarkRow>> rows = ReadLandmarks(arguments.landmarks, map);
    if (!rows.ok()) return rows.status();
    absl::StatusOr<EditableMap> mended = ReplaceLandmarks(map, *rows, counts);
    if (!mended.ok()) return mended.status();
    map = *std::move(mended);
  } else {
    counts.same = map.PointCount();
  }
  if (arguments.trajectory.empty()) return map;
  const auto format = TrajectoryFormatOf(arguments.trajectory, "");
  if (!format.ok()) return format.status();
  const absl::StatusOr<Trajectory> trajectory = ReadTrajectory(arguments.trajectory, *format);
  if (!trajectory.ok()) return trajectory.status();
  return MoveKeyframes(map, *trajectory, moved_keyframe_count);
}

absl::Status Import(const ImportArguments& arguments) {
  absl::Status status = CheckOutputFiles({{arguments.out}, arguments.force});
  if (!status.ok()) return status;
  absl::StatusOr<EditableMap> base = ReadMapParts(arguments.base);
  if (!base.ok()) return base.status();
  LandmarkEdits counts;
  std::size_t moved_keyframe_count = 0;
  absl::StatusOr<EditableMap> map =
      WithLandmarksOf(arguments, *std::move(base), counts, moved_keyframe_count);
  if (!map.ok()) return map.status();
  if (counts.same + counts.moved + counts.edited == 0) {
    absl::FPrintF(stderr,
                  "%s: none of its landmarks is one of %s; --base must be the map that was "
                  "exported\n",
                  Visible(arguments.landmarks), Visible(arguments.base));
  }
  if (!arguments.name.empty()) map->name = arguments.name;
  const absl::StatusOr<MapInfo> info = WriteMapParts(*map, arguments.out);
  if (!info.ok()) return info.status();
  if (arguments.json) {
    PrintJson({{"file", arguments.out},
               {"map", MapInfoJson(*info)},
               {"landmarks",
                {{"same_count", counts.same},
                 {"moved_count", counts.moved},
                 {"edited_count", counts.edited},
                 {"added_count", counts.added},
                 {"removed_count", counts.removed}}},
               {"moved_keyframe_count", moved_keyframe_count}});
    return absl::OkStatus();
  }
  absl::PrintF(
      "%s: %d landmarks: %d as they were, %d moved, %d edited, %d added; %d removed; "
      "%d keyframes moved\n",
      Visible(arguments.out), info->point_count, counts.same, counts.moved, counts.edited,
      counts.added, counts.removed, moved_keyframe_count);
  return absl::OkStatus();
}

void AddExport(CLI::App& map, int& exit_code) {
  auto arguments = std::make_shared<ExportArguments>();
  CLI::App* app = map.add_subcommand(
      "export", "Write a map's landmarks and keyframes for GIS and robotics tools");
  app->add_option("file", arguments->file, "Map file")->required()->type_name("FILE");
  CLI::Option* landmarks =
      app->add_option("--landmarks", arguments->landmarks,
                      "Landmarks: GeoJSON in WGS 84, or PCD in the map frame less the local origin")
          ->check(CheckLandmarkFile)
          ->type_name("GEOJSON|PCD");
  CLI::Option* trajectory = AddTrajectoryOptions(*app, arguments->trajectory);
  AddForceOption(*app, arguments->force);
  app->add_flag("--json", arguments->json, "Print what was written as JSON");
  app->footer(
      "The trajectory is that of the keyframes; a stamp is a keyframe's number in seconds.\n"
      "`map import` reads GeoJSON and PCD of landmarks, TUM and CSV of keyframes.\n"
      "Example:\n"
      "  dcloc map export town.dclm --landmarks town.geojson --trajectory-out town.tum");
  app->callback([arguments, landmarks, trajectory, &exit_code] {
    if (landmarks->count() == 0 && trajectory->count() == 0) {
      throw CLI::RequiredError("At least one of --landmarks and --trajectory-out");
    }
    const absl::Status status = Export(*arguments);
    exit_code = status.ok() ? kSuccess : Fail(status);
  });
}

void AddImport(CLI::App& map, int& exit_code) {
  auto arguments = std::make_shared<ImportArguments>();
  CLI::App* app =
      map.add_subcommand("import", "Make a map of one whose landmarks other tools have mended");
  app->add_option("--base", arguments->base, "Map file that was exported")
      ->required()
      ->type_name("FILE");
  CLI::Option* landmarks =
      app->add_option("--landmarks", arguments->landmarks,
                      "Landmarks as `map export` writes them; those that are missing go")
          ->check(CheckLandmarkFile)
          ->type_name("GEOJSON|PCD");
  CLI::Option* trajectory =
      app->add_option("--trajectory", arguments->trajectory,
                      "Keyframes as `map export` writes them; they take their landmarks along")
          ->type_name("TUM|CSV");
  app->add_option("--name", arguments->name, "Name of the map; the base's by default");
  app->add_option("--out", arguments->out, "Map file to write")->required()->type_name("FILE");
  AddForceOption(*app, arguments->force);
  app->add_flag("--json", arguments->json, "Print what was changed as JSON");
  app->footer(
      "What was not changed is the base's to the last bit. A landmark that was moved by less than\n"
      "a centimetre was not: other tools round. A new landmark needs its covariance (xx_m2, ...)\n"
      "and counts; without `keyframe` the covariance is in the map frame.\n"
      "Example:\n"
      "  dcloc map import --base town.dclm --landmarks mended.geojson --out mended.dclm");
  app->callback([arguments, landmarks, trajectory, &exit_code] {
    if (landmarks->count() == 0 && trajectory->count() == 0) {
      throw CLI::RequiredError("At least one of --landmarks and --trajectory");
    }
    const absl::Status status = Import(*arguments);
    exit_code = status.ok() ? kSuccess : Fail(status);
  });
}

}  // namespace

void AddMapExchangeCommands(CLI::App& map_command, int& exit_code) {
  AddExport(map_command, exit_code);
  AddImport(map_command, exit_code);
}

}  // namespace dcloc::cli
