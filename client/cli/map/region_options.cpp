#include "client/cli/map/region_options.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "client/cli/common/input_file.h"
#include "client/landmarks/region_geojson.h"

namespace dcloc::cli {
namespace {

// CLI11 gives the values of all uses of an option in one list, so that each use is one call.
void Add(PlanarPolygon polygon, const char* option, PlanarRegion& region) {
  if (absl::Status status = Validate(PlanarRegion{.polygons = {polygon}}); !status.ok()) {
    throw CLI::ValidationError(option, std::string(status.message()));
  }
  region.polygons.push_back(std::move(polygon));
}

std::vector<double> NumbersOf(const std::string& text, const char* option) {
  std::vector<double> numbers;
  for (const std::string& word : CLI::detail::split(text, ',')) {
    double value = 0.0;
    if (!CLI::detail::lexical_cast(word, value)) {
      throw CLI::ValidationError(option, absl::StrCat("'", word, "' is no number"));
    }
    numbers.push_back(value);
  }
  return numbers;
}

void AddBox(const std::string& text, PlanarRegion& region) {
  const std::vector<double> v = NumbersOf(text, "--box");
  if (v.size() != 4) {
    throw CLI::ValidationError("--box", absl::StrCat("has ", v.size(), " numbers; it must be 4"));
  }
  Add(BoxPolygon({v[0], v[1]}, {v[2], v[3]}), "--box", region);
}

void AddPolygon(const std::string& text, PlanarRegion& region) {
  const std::vector<double> v = NumbersOf(text, "--polygon");
  if (v.size() < 6 || v.size() % 2 != 0) {
    throw CLI::ValidationError(
        "--polygon",
        absl::StrCat("has ", v.size(), " numbers; it must be two a vertex, 3 vertices at least"));
  }
  PlanarPolygon polygon{.rings_m = {{}}};
  for (std::size_t i = 0; i < v.size(); i += 2) {
    polygon.rings_m.front().emplace_back(v[i], v[i + 1]);
  }
  Add(std::move(polygon), "--polygon", region);
}

}  // namespace

void AddRegionOptions(CLI::App& command, RegionArguments& arguments) {
  CLI::Option_group* group = command.add_option_group("Region", "Together they are the region");
  PlanarRegion& region = arguments.in_map;
  group
      ->add_option_function<std::vector<std::string>>(
          "--box",
          [&region](const std::vector<std::string>& texts) {
            for (const std::string& text : texts) AddBox(text, region);
          },
          "A box in the map frame [m], by two corners; may be given several times")
      ->expected(1)
      ->take_all()
      ->type_name("X,Y,X,Y");
  group
      ->add_option_function<std::vector<std::string>>(
          "--polygon",
          [&region](const std::vector<std::string>& texts) {
            for (const std::string& text : texts) AddPolygon(text, region);
          },
          "A polygon in the map frame [m], by its vertices; may be given several times")
      ->expected(1)
      ->take_all()
      ->type_name("X,Y,X,Y,X,Y,...");
  group
      ->add_option("--region", arguments.geojson,
                   "Polygons of GeoJSON files, in WGS 84; the map needs an anchor")
      ->delimiter(',')
      ->check(CLI::ExistingFile)
      ->type_name("GEOJSON,...");
  group->require_option(1, 0);
}

absl::StatusOr<PlanarRegion> RegionOf(const RegionArguments& arguments, const EditableMap& map) {
  PlanarRegion region = arguments.in_map;
  const std::optional<GeodeticAnchor> anchor = map.Anchor();
  for (const std::string& file : arguments.geojson) {
    if (!anchor) {
      return absl::FailedPreconditionError(absl::StrCat(
          file, ": has places on the Earth, and the map has no anchor; use --box or --polygon"));
    }
    const absl::StatusOr<std::string> text = ReadInputFile(file);
    if (!text.ok()) return text.status();
    absl::StatusOr<PlanarRegion> read = ParseRegionGeoJson(*text, file, *anchor);
    if (!read.ok()) return read.status();
    for (PlanarPolygon& polygon : read->polygons) region.polygons.push_back(std::move(polygon));
  }
  return region;
}

}  // namespace dcloc::cli
