#include "client/cli/map/server/map_place_command.h"

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/common/terminal.h"
#include "client/cli/map/server/map_call.h"

namespace dcloc::cli {
namespace {

constexpr double kDefaultRadius_m = 50.0;

nlohmann::ordered_json AccuracyJson(const v1::ExpectedAccuracy& accuracy) {
  nlohmann::ordered_json json = {{"along_sigma_m", nullptr},
                                 {"across_sigma_m", nullptr},
                                 {"heading_sigma_rad", nullptr},
                                 {"is_tunnel", accuracy.is_tunnel()},
                                 {"is_alias", accuracy.is_alias()}};
  if (accuracy.has_along_sigma_m()) {
    json["along_sigma_m"] = accuracy.along_sigma_m();
    json["across_sigma_m"] = accuracy.across_sigma_m();
    json["heading_sigma_rad"] = accuracy.heading_sigma_rad();
  }
  return json;
}

nlohmann::ordered_json AccuracyJson(const v1::MapCoverage& coverage) {
  if (!coverage.has_accuracy()) return nullptr;
  return AccuracyJson(coverage.accuracy());
}

std::string AccuracyText(const v1::MapCoverage& coverage) {
  if (!coverage.has_accuracy()) return "not known";
  const v1::ExpectedAccuracy& accuracy = coverage.accuracy();
  std::string text = "no pose";
  if (accuracy.has_along_sigma_m()) {
    text = absl::StrFormat("%.2f m along, %.2f m across", accuracy.along_sigma_m(),
                           accuracy.across_sigma_m());
  }
  if (accuracy.is_tunnel()) text += ", tunnel";
  if (accuracy.is_alias()) text += ", looks like another place";
  return text;
}

absl::Status FindCoverage(client::MapClient& maps, const MapArguments& arguments) {
  const auto coverages = maps.FindCoverage(arguments.coverage);
  if (!coverages.ok()) return coverages.status();
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  std::vector<std::vector<std::string>> rows = {
      {"map", "version", "distance [m]", "to expect there"}};
  for (const v1::MapCoverage& coverage : *coverages) {
    list.push_back({{"map", coverage.map_name()},
                    {"version", coverage.version()},
                    {"distance_m", coverage.distance_m()},
                    {"accuracy", AccuracyJson(coverage)}});
    rows.push_back({coverage.map_name(), absl::StrCat(coverage.version()),
                    absl::StrFormat("%.1f", coverage.distance_m()), AccuracyText(coverage)});
  }
  absl::PrintF("%s", arguments.json ? list.dump(2) + "\n" : FormatTable(rows));
  return absl::OkStatus();
}

/// Landmarks as (x, y, z, radar cross-section) and keyframes as (x, y), in the map frame.
nlohmann::ordered_json TileJson(const v1::ReadMapTileResponse& tile) {
  const v1::Vector3& origin = tile.origin_m();
  nlohmann::ordered_json points = nlohmann::ordered_json::array();
  for (int i = 0; i < tile.x_m_size(); ++i) {
    points.push_back({origin.x() + tile.x_m(i), origin.y() + tile.y_m(i), origin.z() + tile.z_m(i),
                      tile.rcs_dbsm(i)});
  }
  nlohmann::ordered_json keyframes = nlohmann::ordered_json::array();
  for (int i = 0; i < tile.keyframe_x_m_size(); ++i) {
    keyframes.push_back({origin.x() + tile.keyframe_x_m(i), origin.y() + tile.keyframe_y_m(i)});
  }
  nlohmann::ordered_json accuracies = nlohmann::ordered_json::array();
  for (const v1::ExpectedAccuracy& accuracy : tile.keyframe_accuracies()) {
    accuracies.push_back(AccuracyJson(accuracy));
  }
  return {{"version", tile.version()},
          {"point_count", tile.point_count()},
          {"points", std::move(points)},
          {"keyframes", std::move(keyframes)},
          {"keyframe_accuracies", std::move(accuracies)}};
}

absl::Status ReadTile(client::MapClient& maps, const MapArguments& arguments) {
  v1::ReadMapTileRequest request = arguments.tile;
  request.set_map_name(arguments.map);
  request.set_version(arguments.version);
  const auto tile = maps.ReadTile(request);
  if (!tile.ok()) return tile.status();
  if (arguments.json) {
    absl::PrintF("%s\n", TileJson(*tile).dump());
    return absl::OkStatus();
  }
  absl::PrintF("x_m,y_m,z_m,rcs_dbsm\n");
  const v1::Vector3& origin = tile->origin_m();
  for (int i = 0; i < tile->x_m_size(); ++i) {
    absl::PrintF("%.3f,%.3f,%.3f,%.1f\n", origin.x() + tile->x_m(i), origin.y() + tile->y_m(i),
                 origin.z() + tile->z_m(i), tile->rcs_dbsm(i));
  }
  return absl::OkStatus();
}

/// An option whose value `set` takes.
template <typename Set>
CLI::Option* AddNumber(CLI::App& app, const char* name, const char* unit, const char* description,
                       const Set& set) {
  return app.add_option_function<double>(name, set, description)->type_name(unit);
}

void AddCoverage(CLI::App& map_command, int& exit_code) {
  auto arguments = std::make_shared<MapArguments>();
  v1::FindCoverageRequest* request = &arguments->coverage;
  request->set_radius_m(kDefaultRadius_m);
  request->set_with_accuracy(true);
  CLI::App* app = AddMapCall(map_command, "coverage", "Say which active maps cover a place",
                             &FindCoverage, arguments, exit_code);
  CLI::Option* latitude =
      AddNumber(*app, "--latitude-deg", "DEG", "The place on the Earth (WGS 84)",
                [request](double deg) { request->mutable_position()->set_latitude_deg(deg); });
  CLI::Option* longitude =
      AddNumber(*app, "--longitude-deg", "DEG", "Its longitude",
                [request](double deg) { request->mutable_position()->set_longitude_deg(deg); });
  CLI::Option* map = app->add_option_function<std::string>(
                            "--map",
                            [request](const std::string& name) {
                              request->mutable_map_place()->set_map_name(name);
                            },
                            "Or the place in the frame of this map")
                         ->type_name("NAME");
  CLI::Option* x =
      AddNumber(*app, "--x-m", "M", "Along that frame's x axis",
                [request](double metres) { request->mutable_map_place()->set_x_m(metres); });
  CLI::Option* y = AddNumber(*app, "--y-m", "M", "Along its y axis", [request](double metres) {
    request->mutable_map_place()->set_y_m(metres);
  });
  AddNumber(*app, "--radius-m", "M", "How far the nearest mapped street may be; 50 by default",
            [request](double metres) { request->set_radius_m(metres); });
  latitude->needs(longitude);
  longitude->needs(latitude)->excludes(map);
  map->needs(x)->needs(y);
  x->needs(map);
  y->needs(map);
  AddJson(*app, *arguments);
  app->footer(
      "Examples:\n"
      "  dcloc map coverage --server localhost:50051 --latitude-deg 1.2986 --longitude-deg 103.78\n"
      "  dcloc map coverage --server localhost:50051 --map town --x-m 120 --y-m 40");
}

void AddTile(CLI::App& map_command, int& exit_code) {
  auto arguments = std::make_shared<MapArguments>();
  v1::ReadMapTileRequest* tile = &arguments->tile;
  CLI::App* app =
      AddMapCall(map_command, "tile", "Print the landmarks of a rectangle, for a viewer", &ReadTile,
                 arguments, exit_code);
  AddMapName(*app, *arguments, "The map")->required();
  AddVersion(*app, *arguments)->description("Its version; the active one if not given");
  AddNumber(*app, "--min-x-m", "M", "The rectangle in the map's frame: least x",
            [tile](double metres) { tile->set_min_x_m(metres); })
      ->required();
  AddNumber(*app, "--min-y-m", "M", "Least y", [tile](double metres) {
    tile->set_min_y_m(metres);
  })->required();
  AddNumber(*app, "--max-x-m", "M", "Greatest x, at most 5000 above the least",
            [tile](double metres) { tile->set_max_x_m(metres); })
      ->required();
  AddNumber(*app, "--max-y-m", "M", "Greatest y, at most 5000 above the least",
            [tile](double metres) { tile->set_max_y_m(metres); })
      ->required();
  app->add_option_function<std::int32_t>(
         "--max-points", [tile](std::int32_t count) { tile->set_max_point_count(count); },
         "Of more landmarks, each second, third ... is taken; 20000 by default")
      ->check(CLI::Range(1, 50'000))
      ->type_name("N");
  AddJson(*app, *arguments);
  app->footer(
      "A line each: where it is in the map's frame, and its radar cross-section. With --json also\n"
      "the keyframes, and how many landmarks there are in the rectangle.\n"
      "Example:\n"
      "  dcloc map tile --server localhost:50051 --map town --min-x-m -50 --max-x-m 50 \\\n"
      "      --min-y-m -50 --max-y-m 50 > tile.csv");
}

}  // namespace

void AddMapPlaceCommands(CLI::App& map_command, int& exit_code) {
  AddCoverage(map_command, exit_code);
  AddTile(map_command, exit_code);
}

}  // namespace dcloc::cli
