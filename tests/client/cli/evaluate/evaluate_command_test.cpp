#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/client/cli/fixtures/simulated.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

class EvaluateCommandTest : public Simulated {};

TEST_F(EvaluateCommandTest, EvaluatesAndWritesWhatIsAskedFor) {
  const Result result =
      Dcloc("evaluate " + Dataset() + " --map-drive map --drive live-0,map --json " +
            File("e.json") + " --csv " + File("e.csv") + " --report " + File("e.html") +
            " --trajectory-out " + File("e.geojson") + " --anchor 48.1,11.6");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("RTE mean / median / rms / p95 / max [m]"));
  const auto json = nlohmann::json::parse(ReadText(File("e.json")));
  ASSERT_EQ(json["drives"].size(), 2U);
  EXPECT_EQ(json["drives"][0]["drive"], "live-0");
  EXPECT_EQ(json["scans"],
            json["drives"][0]["scans"].get<int>() + json["drives"][1]["scans"].get<int>());
  EXPECT_LT(json["rte_m"]["median"].get<double>(), 0.3);
  EXPECT_EQ(json["misleading_count"], 0);
  EXPECT_THAT(ReadText(File("e.csv")), HasSubstr("live-0,"));
  EXPECT_THAT(ReadText(File("e.html")), HasSubstr("without Doppler compensation"));
  EXPECT_TRUE(std::filesystem::exists(File("e-live-0.png")));
  const auto way = nlohmann::json::parse(ReadText(File("e-live-0.geojson")))["features"][0];
  EXPECT_EQ(way["properties"]["name"], "live-0");
  EXPECT_GT(way["geometry"]["coordinates"].size(), 50U);
  EXPECT_TRUE(std::filesystem::exists(File("e-map.geojson")));
}

TEST_F(EvaluateCommandTest, EvaluatesEachDriveInItsOwnMap) {
  const auto medians = [&](const std::string& drives) {
    const Result result =
        Dcloc("evaluate " + Dataset() + " " + drives + " --json " + File("own.json"));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    std::vector<double> found;
    const auto json = nlohmann::json::parse(ReadText(File("own.json")));
    for (const auto& drive : json["drives"]) found.push_back(drive["rte_m"]["median"]);
    return found;
  };
  const auto own = medians("--map-drive map,live-0 --drive live-0,map");
  ASSERT_EQ(own.size(), 2U);
  EXPECT_EQ(own[0], medians("--map-drive map --drive live-0").at(0));
  EXPECT_EQ(own[1], medians("--map-drive live-0 --drive map").at(0));

  const Result result = Dcloc("evaluate " + Dataset() + " --map-drive map,live-0 --drive live-0");
  EXPECT_NE(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("--map-drive names 2 drives, --drive 1"));
}

TEST_F(EvaluateCommandTest, ShowsWhatCompensationIsWorth) {
  const auto median = [&](const std::string& options) {
    const Result result =
        Dcloc("evaluate " + Dataset() + " --map-drive map --drive live-0 --json " + File("c.json") +
              " " + options);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return nlohmann::json::parse(ReadText(File("c.json")))["rte_m"]["median"].get<double>();
  };
  const double with_m = median("");
  // Range-Doppler coupling of 0.04 s shifts a map made at 72 km/h against scans at 40 km/h.
  EXPECT_GT(median("--without doppler"), with_m + 0.05);
  EXPECT_GT(median("--beta-s 0"), with_m + 0.05);
}

}  // namespace
}  // namespace dcloc
