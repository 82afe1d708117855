// The program `dcloc` as a user meets it: what it prints, what it writes, what it returns.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "tests/client/cli/fixtures/dcloc_process.h"
#include "tests/client/datasets/temp_folder.h"
#include "tests/client/datasets/tiny_nuscenes.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string ReadText(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// A short simulated data set that all tests of evaluation share.
class Simulated : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder();
    const Result result = Dcloc("simulate --length-m 200 --out " + Root());
    ASSERT_EQ(result.exit_code, 0) << result.err;
  }
  static void TearDownTestSuite() { delete folder_; }
  static std::string Root() { return (folder_->path() / "town").string(); }
  static std::string File(const std::string& name) { return (folder_->path() / name).string(); }
  static std::string Dataset() { return "--dataset nuscenes --root " + Root(); }

  static TempFolder* folder_;
};

TempFolder* Simulated::folder_ = nullptr;

TEST(CommandLine, HelpsWithAnExampleForEachCommand) {
  for (const char* command : {"simulate", "map build", "map inspect", "evaluate"}) {
    const Result result = Dcloc(std::string(command) + " --help");
    EXPECT_EQ(result.exit_code, 0) << command;
    EXPECT_THAT(result.out, HasSubstr("Example")) << command;
    EXPECT_THAT(result.out, HasSubstr(std::string("dcloc ") + command)) << command;
  }
  EXPECT_EQ(Dcloc("--help").exit_code, 0);
}

/// All commands that can be run, by the program's own help.
std::vector<std::string> Commands(const std::string& path = "") {
  std::vector<std::string> commands;
  std::istringstream help(Dcloc(path + " --help").out);
  bool has_any = false;
  bool listed = false;  // up to the next empty line
  for (std::string line; std::getline(help, line);) {
    listed = (listed && !line.empty()) || line == "Subcommands:";
    has_any = has_any || listed;
    if (!listed || line.rfind("  ", 0) != 0 || line[2] == ' ') continue;
    const std::string name = line.substr(2, line.find(' ', 2) - 2);
    const std::vector<std::string> below = Commands(absl::StrCat(path, " ", name));
    commands.insert(commands.end(), below.begin(), below.end());
  }
  if (!has_any) commands.push_back(path.substr(1));
  return commands;
}

TEST(CommandLine, EveryCommandHasAnExample) {
  const std::vector<std::string> commands = Commands();
  EXPECT_GT(commands.size(), 15U);
  for (const std::string& command : commands) {
    const Result result = Dcloc(command + " --help");
    EXPECT_EQ(result.exit_code, 0) << command;
    EXPECT_THAT(result.out, HasSubstr("Example")) << command;
    EXPECT_THAT(result.out, HasSubstr("dcloc " + command)) << command;
  }
}

/// What bash offers for the word behind "dcloc WORDS".
std::string Offered(const std::string& words) {
  const std::string script =
      "bash -c '. <(" + std::string(DCLOC_PROGRAM) + " completion); COMP_WORDS=(dcloc " + words +
      " \"\"); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _dcloc; echo \"${COMPREPLY[*]}\"'";
  FILE* pipe = popen(script.c_str(), "r");  // NOLINT(cert-env33-c): the words are this test's own
  std::array<char, 8192> buffer{};
  const std::size_t size = fread(buffer.data(), 1, buffer.size(), pipe);
  pclose(pipe);
  return {buffer.data(), size};
}

TEST(CommandLine, CompletesWhatThereIs) {
  EXPECT_THAT(Offered(""),
              ::testing::AllOf(HasSubstr("map"), HasSubstr("session"), HasSubstr("--version")));
  EXPECT_THAT(Offered("session"), ::testing::AllOf(HasSubstr("watch"), HasSubstr("replay"),
                                                   ::testing::Not(HasSubstr("upload"))));
  EXPECT_THAT(Offered("session list"), HasSubstr("--token-file"));
  EXPECT_THAT(Offered("map delete --map x"), HasSubstr("--all-versions"))
      << "options of groups are there as well";
}

TEST(CommandLine, TheManualHasEveryCommandAndOption) {
  const std::string manual = Dcloc("manual").out;
  for (const std::string& command : Commands()) {
    const std::string escaped = absl::StrReplaceAll(command, {{"-", "\\-"}});
    EXPECT_THAT(manual, HasSubstr(".SS dcloc " + escaped + "\n")) << command;
  }
  for (const char* text :
       {"\\-\\-token\\-file", "\\-\\-all\\-versions", "DCLOC_TOKEN_FILE", ".TH DCLOC 1"}) {
    EXPECT_THAT(manual, HasSubstr(text));
  }
}

TEST(CommandLine, WhatAsksAServerAnswersScriptsToo) {
  int count = 0;
  for (const std::string& command : Commands()) {
    const std::string help = Dcloc(command + " --help").out;
    if (!absl::StrContains(help, "--token-file")) continue;
    EXPECT_THAT(help, HasSubstr("--json")) << command;
    ++count;
  }
  EXPECT_GT(count, 15);
}

TEST(CommandLine, SaysItsVersion) {
  const Result result = Dcloc("--version");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out,
              ::testing::MatchesRegex("dcloc [0-9]+\\.[0-9]+\\.[0-9]+\nbuild [0-9a-f]+, .+\n"));
}

TEST(CommandLine, ReturnsTwoForWhatMakesNoSense) {
  for (const char* arguments :
       {"", "fly", "map", "map build", "map inspect", "evaluate --dataset kitti",
        "map build --dataset nuscenes --root /nonexistent --drive a --out b", "--no-such-option"}) {
    const Result result = Dcloc(arguments);
    EXPECT_EQ(result.exit_code, 2) << arguments;
    EXPECT_FALSE(result.err.empty()) << arguments;
    EXPECT_THAT(result.out, IsEmpty()) << arguments;
  }
}

TEST(CommandLine, ReturnsOneForWhatFails) {
  const TempFolder folder;
  TinyNuScenes().WriteTo(folder);
  const std::string root = folder.path().string();
  const Result no_scene =
      Dcloc("map build --dataset nuscenes --root " + root + " --drive scene-7 --out /dev/null");
  EXPECT_EQ(no_scene.exit_code, 1);
  EXPECT_THAT(no_scene.err, HasSubstr("there is no scene \"scene-7\""));
  const Result no_map = Dcloc("map inspect " + root + "/none.dclm");
  EXPECT_EQ(no_map.exit_code, 1);
  EXPECT_THAT(no_map.err, HasSubstr("none.dclm"));
  const Result no_beta = Dcloc("map build --dataset nuscenes --root " + root +
                               " --drive scene-0001 --beta-s 1e9 --out " + root + "/map");
  EXPECT_EQ(no_beta.exit_code, 1);
  EXPECT_THAT(no_beta.err, HasSubstr("beta_s"));
}

TEST_F(Simulated, BuildsAndInspectsAMap) {
  const Result built =
      Dcloc("map build " + Dataset() + " --drive map --name town --json --out " + File("a.dclm"));
  ASSERT_EQ(built.exit_code, 0) << built.err;
  EXPECT_THAT(built.err, IsEmpty());  // no progress where stderr is no terminal
  const auto made = nlohmann::json::parse(built.out);
  EXPECT_EQ(made["name"], "town");
  EXPECT_GT(made["point_count"], 50);
  EXPECT_NEAR(made["length_m"].get<double>(), 200.0, 60.0);
  EXPECT_EQ(made["size_bytes"], std::filesystem::file_size(File("a.dclm")));

  const Result inspected = Dcloc("map inspect --json " + File("a.dclm"));
  EXPECT_EQ(inspected.exit_code, 0) << inspected.err;
  EXPECT_EQ(nlohmann::json::parse(inspected.out), made);
  EXPECT_THAT(Dcloc("map inspect " + File("a.dclm")).out, HasSubstr("name         town\n"));
}

TEST_F(Simulated, SurveysADriveWithoutItsPoses) {
  const Result made = Dcloc("map survey " + Dataset() +
                            " --drive map,live-0 --compare-truth --json --trajectory-out " +
                            File("s.tum") + " --out " + File("s.dclm"));
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const auto json = nlohmann::json::parse(made.out);
  EXPECT_TRUE(json["drives"][0]["is_in_map"]);
  EXPECT_TRUE(json["drives"][1]["is_in_map"]) << json["drives"][1]["reason"];
  EXPECT_LT(json["truth"]["rmse_m"], 0.5);
  EXPECT_EQ(json["truth"]["wrong_loop_count"], 0);
  EXPECT_EQ(Dcloc("map inspect " + File("s.dclm")).exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(File("s.tum")));
  for (const char* const drive : {"map", "live-0"}) {
    const std::string tum = ReadText(File(absl::StrCat("s-", drive, ".tum")));
    const auto pose_count = std::count(tum.begin(), tum.end(), '\n');
    EXPECT_GT(pose_count, 50) << drive;
    EXPECT_EQ(std::count(tum.begin(), tum.end(), ' '), 7 * pose_count) << drive;
  }
}

TEST_F(Simulated, SurveyWritesNothingWhenNothingMoved) {
  const Result none =
      Dcloc("map survey " + Dataset() + " --drive map --to-s 0.3 --out " + File("none.dclm"));
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.err, HasSubstr("map: it moved"));
  EXPECT_FALSE(std::filesystem::exists(File("none.dclm")));
}

TEST_F(Simulated, CalibratesARigThatAMapIsBuiltWith) {
  const Result result = Dcloc("calibrate " + Dataset() + " --drive map,live-0 --beta-s 0 --json" +
                              " --out " + File("rig.json"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto beta = nlohmann::json::parse(result.out)["radars"][0]["beta_s"];
  EXPECT_NEAR(beta["correction"].get<double>(), 0.04, 0.01);  // what the simulator measures with
  EXPECT_LT(beta["interval_95"][0].get<double>(), 0.04);
  EXPECT_GT(beta["interval_95"][1].get<double>(), 0.04);
  const auto rig = nlohmann::json::parse(ReadText(File("rig.json")));
  EXPECT_EQ(rig["radars"][0]["beta_s"], beta["correction"]);
  EXPECT_EQ(rig["radars"][0]["beta_sigma_s"], beta["sigma"]);
  const Result built = Dcloc("map build " + Dataset() + " --drive map --rig " + File("rig.json") +
                             " --out " + File("c.dclm"));
  EXPECT_EQ(built.exit_code, 0) << built.err;
  EXPECT_THAT(built.out, HasSubstr("(beta 0.0"));
}

TEST_F(Simulated, KeepsWhatIsKnownForSure) {
  const Result result =
      Dcloc("calibrate " + Dataset() + " --drive map --keep time,range,yaw --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto radar = nlohmann::json::parse(result.out)["radars"][0];
  for (const char* kept : {"time_offset_s", "range_bias_m", "mount_yaw_rad"}) {
    EXPECT_NEAR(radar[kept]["correction"].get<double>(), 0.0, 1e-5) << kept;
    EXPECT_FALSE(radar[kept]["determined"].get<bool>()) << kept;
  }
}

TEST_F(Simulated, TakesAPartOfADrive) {
  const Result whole = Dcloc("map build " + Dataset() + " --drive map --json --out " + File("d"));
  const Result part =
      Dcloc("map build " + Dataset() + " --drive map --to-s 4 --json --out " + File("d"));
  ASSERT_EQ(part.exit_code, 0) << part.err;
  EXPECT_LT(nlohmann::json::parse(part.out)["length_m"].get<double>(),
            0.7 * nlohmann::json::parse(whole.out)["length_m"].get<double>());
  const Result none =
      Dcloc("map build " + Dataset() + " --drive map --from-s 5000 --out " + File("d"));
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.err, HasSubstr("5000"));
}

TEST_F(Simulated, FindsADamagedMap) {
  ASSERT_EQ(Dcloc("map build " + Dataset() + " --drive map --out " + File("b.dclm")).exit_code, 0);
  std::string bytes = ReadText(File("b.dclm"));
  bytes[bytes.size() - 100] = static_cast<char>(bytes[bytes.size() - 100] ^ 1);
  std::ofstream(File("b.dclm"), std::ios::binary) << bytes;
  const Result result = Dcloc("map inspect " + File("b.dclm"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("b.dclm"));
}

TEST_F(Simulated, LeavesNothingBehindWhereItCannotWrite) {
  const std::string target = File("taken");
  std::filesystem::create_directory(target);
  const Result result = Dcloc("map build " + Dataset() + " --drive map --out " + target);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr(target));
  for (const auto& entry : std::filesystem::directory_iterator(folder_->path())) {
    EXPECT_THAT(entry.path().filename().string(), ::testing::Not(HasSubstr("taken.")));
  }
}

TEST_F(Simulated, EvaluatesAndWritesWhatIsAskedFor) {
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

TEST_F(Simulated, EvaluatesEachDriveInItsOwnMap) {
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

TEST_F(Simulated, ShowsWhatCompensationIsWorth) {
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
