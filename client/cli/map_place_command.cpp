#include "client/cli/map_place_command.h"

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/map_call.h"
#include "client/cli/terminal.h"

namespace dcloc::cli {
namespace {

constexpr double kDefaultRadius_m = 50.0;

absl::Status FindCoverage(client::MapClient& maps, const MapArguments& arguments) {
  const auto coverages = maps.FindCoverage(arguments.coverage);
  if (!coverages.ok()) return coverages.status();
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  std::vector<std::vector<std::string>> rows = {{"map", "version", "distance [m]"}};
  for (const v1::MapCoverage& coverage : *coverages) {
    list.push_back({{"map", coverage.map_name()},
                    {"version", coverage.version()},
                    {"distance_m", coverage.distance_m()}});
    rows.push_back({coverage.map_name(), absl::StrCat(coverage.version()),
                    absl::StrFormat("%.1f", coverage.distance_m())});
  }
  absl::PrintF("%s", arguments.json ? list.dump(2) + "\n" : FormatTable(rows));
  return absl::OkStatus();
}

/// An option whose value `set` takes.
template <typename Set>
CLI::Option* AddNumber(CLI::App& app, const char* name, const char* unit, const char* description,
                       const Set& set) {
  return app.add_option_function<double>(name, set, description)->type_name(unit);
}

}  // namespace

void AddMapPlaceCommands(CLI::App& map_command, int& exit_code) {
  auto arguments = std::make_shared<MapArguments>();
  v1::FindCoverageRequest* request = &arguments->coverage;
  request->set_radius_m(kDefaultRadius_m);
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

}  // namespace dcloc::cli
