#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "server/app/server.h"
#include "server/identity/identity_store.h"
#include "tests/client/cli/dcloc_process.h"
#include "tests/core/map/temporary_folder.h"

// The commands of `dcloc` that need a server, as a user meets them.
namespace dcloc {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

std::string ReadText(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// A server of its own for each test; a short simulated drive and its map for all.
class ServerCommandsTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = std::make_unique<TemporaryFolder>();
    Result result = Dcloc("simulate --length-m 200 --out " + Shared("sim"));
    ASSERT_EQ(result.exit_code, 0) << result.err;
    for (const auto& entry : std::filesystem::directory_iterator(Shared("sim") + "/can_bus")) {
      const std::string file = entry.path().filename().string();
      drive_ = std::min(drive_.empty() ? file : drive_, file);
    }
    drive_ = drive_.substr(0, drive_.rfind("_pose.json"));
    result = Dcloc("map build " + Data() + " --out " + Shared("map"));
    ASSERT_EQ(result.exit_code, 0) << result.err;
  }
  static void TearDownTestSuite() { shared_.reset(); }

  void SetUp() override {
    auto server = server::Server::Start({.data = (folder_.path() / "data").string(),
                                         .listen = "127.0.0.1:0",
                                         .log_level = "error"});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    address_ = server_->address();
  }

  static std::string Shared(const char* name) { return (shared_->path() / name).string(); }
  static std::string Data() {
    return "--dataset nuscenes --root " + Shared("sim") + " --drive " + drive_;
  }
  std::string File(const char* name) const { return (folder_.path() / name).string(); }
  std::string At(const std::string& words) const { return words + " --server " + address_ + " "; }
  std::string Localize(const std::string& words) const {
    return At("localize") + "--map town " + Data() + " --out " + File("answers.csv") + " " + words;
  }
  void Upload() const {
    const Result result = Dcloc(At("map upload") + "--map town --activate " + Shared("map"));
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.out, HasSubstr("town version 1, active"));
  }

  // Waits until some answers are in the file.
  void WaitForAnswers() const {
    while (Lines(ReadText(File("answers.csv"))).size() < 20) std::this_thread::sleep_for(20ms);
  }

  // All lines are whole: as many fields as the header, the last one the map version.
  void ExpectWholeLines() const {
    const std::string text = ReadText(File("answers.csv"));
    EXPECT_EQ(text.back(), '\n');
    for (const std::string& line : Lines(text)) {
      EXPECT_EQ(std::ranges::count(line, ','), 47) << line;
    }
  }

  static inline std::unique_ptr<TemporaryFolder> shared_;
  static inline std::string drive_;
  const TemporaryFolder folder_;
  std::unique_ptr<server::Server> server_;
  std::string address_;
};

TEST_F(ServerCommandsTest, MapsAreListedActivatedAndDeleted) {
  Upload();
  ASSERT_EQ(Dcloc("map build " + Data() + " --name second --out " + File("second")).exit_code, 0);
  ASSERT_EQ(Dcloc(At("map upload") + "--map town " + File("second")).exit_code, 0);
  auto maps = nlohmann::json::parse(Dcloc(At("map list") + "--json").out);
  ASSERT_EQ(maps.size(), 1U);
  EXPECT_EQ(maps[0]["name"], "town");
  EXPECT_EQ(maps[0]["active_version"], 1);
  EXPECT_EQ(maps[0]["version_count"], 2);
  EXPECT_EQ(Dcloc(At("map activate") + "--map town --version 2").exit_code, 0);
  const auto versions = nlohmann::json::parse(Dcloc(At("map list") + "--map town --json").out);
  EXPECT_EQ(versions[0]["version"], 2);
  EXPECT_EQ(versions[0]["active"], true);
  EXPECT_GT(versions[0]["point_count"], 100);

  Result result = Dcloc(At("map delete") + "--map town --version 2");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("active"));
  EXPECT_EQ(Dcloc(At("map delete") + "--map town").exit_code, 2);
  EXPECT_EQ(Dcloc(At("map delete") + "--map town --version 2 --drain").exit_code, 1);
  result = Dcloc(At("map delete") + "--map town --version 1 --drain --json");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out)["version"], 1);
  EXPECT_EQ(Dcloc(At("map delete") + "--map town --all-versions").exit_code, 0);
  EXPECT_EQ(nlohmann::json::parse(Dcloc(At("map list") + "--json").out).size(), 0U);
}

TEST_F(ServerCommandsTest, TheTokenIsGivenByFlagOrEnvironment) {
  const auto identities =
      *server::IdentityStore::Open(server::IdentityFile(folder_.path() / "data"));
  std::ofstream(File("token")) << *identities->Create(server::Proof::kToken, {.name = "ops"}, {})
                               << "\n";
  Result result = Dcloc(At("map list"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("Bearer"));
  EXPECT_EQ(Dcloc(At("map list") + "--token-file " + File("token")).exit_code, 0);
  setenv("DCLOC_TOKEN_FILE", File("token").c_str(), 1);
  result = Dcloc(At("map list"));
  unsetenv("DCLOC_TOKEN_FILE");
  EXPECT_EQ(result.exit_code, 0) << result.err;
}

TEST_F(ServerCommandsTest, LabelsAreSetAndTakenBack) {
  Upload();
  ASSERT_EQ(Dcloc("map build " + Data() + " --name second --out " + File("second")).exit_code, 0);
  ASSERT_EQ(Dcloc(At("map upload") + "--map town " + File("second")).exit_code, 0);
  Result result = Dcloc(At("map rollback") + "--map town");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("active before"));
  result = Dcloc(At("map canary") + "--map town --version 2 --share 0.25");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("25 % of the vehicles get version 2"));
  EXPECT_EQ(Dcloc(At("map canary") + "--map town --version 2").exit_code, 2);
  EXPECT_EQ(Dcloc(At("map canary") + "--map town --version 2 --none").exit_code, 2);
  EXPECT_EQ(Dcloc(At("map canary") + "--map town --version 2 --share 2").exit_code, 2);
  auto map = nlohmann::json::parse(Dcloc(At("map canary") + "--map town --none --json").out);
  EXPECT_EQ(map["canary_version"], 0);
  map = nlohmann::json::parse(Dcloc(At("map activate") + "--map town --version 2 --json").out);
  EXPECT_EQ(map["active_version"], 2);
  EXPECT_EQ(map["previous_version"], 1);
  map = nlohmann::json::parse(Dcloc(At("map rollback") + "--map town --move-sessions --json").out);
  EXPECT_EQ(map["active_version"], 1);
  EXPECT_EQ(map["moved_session_count"], 0);
}

TEST_F(ServerCommandsTest, MapsAreFoundByPlaceAndDownloaded) {
  Upload();
  const std::string place = " --map town --x-m 0 --y-m 0 ";
  Result result = Dcloc(At("map coverage") + place + "--radius-m 10000 --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto coverages = nlohmann::json::parse(result.out);
  ASSERT_EQ(coverages.size(), 1U);
  EXPECT_EQ(coverages[0]["map"], "town");
  EXPECT_EQ(coverages[0]["version"], 1);
  EXPECT_THAT(Dcloc(At("map coverage") + place).out, HasSubstr("distance [m]"));
  result = Dcloc(At("map coverage") + "--latitude-deg 91 --longitude-deg 0");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("latitude_deg"));
  EXPECT_EQ(Dcloc(At("map coverage") + "--latitude-deg 1").exit_code, 2);
  EXPECT_EQ(Dcloc(At("map coverage") + "--map town").exit_code, 2);

  result = Dcloc(At("map download") + "--map town --out " + File("copy"));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(ReadText(File("copy")), ReadText(Shared("map")));
  EXPECT_EQ(Dcloc(At("map download") + "--map city --out " + File("city")).exit_code, 1);
  EXPECT_FALSE(std::filesystem::exists(File("city")));
}

TEST_F(ServerCommandsTest, AServerMakesAMapOfADrive) {
  const std::string build = At("map remote-build") + "--map town --activate " + Data();
  Result result = Dcloc(build + " --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto version = nlohmann::json::parse(result.out);
  EXPECT_EQ(version["version"], 1);
  EXPECT_EQ(version["active"], true);
  EXPECT_GT(version["point_count"], 100);
  const auto builds = nlohmann::json::parse(Dcloc(At("map builds") + "--json").out);
  ASSERT_EQ(builds.size(), 1U);
  EXPECT_EQ(builds[0]["state"], "done");
  EXPECT_EQ(builds[0]["done_scan_count"], builds[0]["scan_count"]);
  result = Dcloc(build + " --no-wait");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("of town: running"));
  result = Dcloc(At("map cancel-build") + "--build nobody");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("nobody"));
  EXPECT_EQ(Dcloc(Localize("--rate max")).exit_code, 0);
}

TEST_F(ServerCommandsTest, ADriveIsLocalizedAndTheAnswersAreKept) {
  Upload();
  const Result result = Dcloc(Localize("--rate max --tum " + File("answers.txt")));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("RTE mean"));
  ExpectWholeLines();
  const std::vector<std::string> csv = Lines(ReadText(File("answers.csv")));
  EXPECT_THAT(result.out, HasSubstr(std::to_string(csv.size() - 1) + " of " +
                                    std::to_string(csv.size() - 1) + " scans were answered"));
  EXPECT_EQ(csv[0].rfind("stamp_ns,radar,state,x,y,z,qx,qy,qz,qw,c00,c01,", 0), 0U);
  EXPECT_THAT(csv[0], HasSubstr(",c54,c55,latency_ms,map_version"));
  const auto tracking = std::ranges::count_if(
      csv, [](const std::string& line) { return line.find(",TRACKING,") != std::string::npos; });
  EXPECT_GT(tracking, static_cast<long>(csv.size() / 2));
  const std::vector<std::string> tum = Lines(ReadText(File("answers.txt")));
  EXPECT_GE(tum.size(), static_cast<std::size_t>(tracking));
  EXPECT_EQ(std::ranges::count(tum[0], ' '), 7);

  const auto json = nlohmann::json::parse(Dcloc(Localize("--rate max --json")).out);
  EXPECT_EQ(json["scan_count"], csv.size() - 1);
  EXPECT_EQ(json["refused"], 0);
  EXPECT_LT(json["rte_m"]["median"], 0.2);
}

TEST_F(ServerCommandsTest, AServerIsLoadedAndEachAnswerIsJudged) {
  Upload();
  const std::string load = At("load") + "--map town " + Data() + " --ramp-s 0.5 --warmup-s 0.5 ";
  Result result = Dcloc(load + "--vehicles 3 --duration-s 3 --target-p99-ms 5000 --json --plot " +
                        File("latency.png"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json["held"], true);
  EXPECT_EQ(json["totals"]["lost_count"], 0);
  EXPECT_GT(json["totals"]["answered_count"], 60);
  EXPECT_GT(json["totals"]["judged_count"], 0) << "poses are compared with the truth";
  EXPECT_LT(json["totals"]["mean_error_m"], 1.0);
  EXPECT_GT(std::filesystem::file_size(File("latency.png")), 1000U);

  result = Dcloc(load + "--vehicles 2 --duration-s 2 --target-p99-ms 0.001");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("the target is 0.001 ms"));
  EXPECT_THAT(result.out, HasSubstr("scans/s"));

  result = Dcloc(load +
                 "--vehicles 1 --max-vehicles 2 --search --target-p99-ms 5000 "
                 "--duration-s 2 --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out)["vehicle_count"], 2);
  EXPECT_EQ(Dcloc(load + "--search").exit_code, 2) << "a search needs a target";
}

TEST_F(ServerCommandsTest, AVehiclesRecordingIsReplayedToTheBit) {
  Upload();
  const std::string file = File("session.rec");
  ASSERT_EQ(Dcloc(Localize("--rate max --record " + file)).exit_code, 0);
  Result result = Dcloc("session replay " + file + " --json --map " + Shared("map"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto here = nlohmann::json::parse(result.out);
  EXPECT_EQ(here["vehicle_id"], "dcloc-localize");
  EXPECT_GT(here["equal_count"], 100);
  EXPECT_EQ(here["different_count"], 0);
  result = Dcloc(At("session replay") + file + " --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out)["equal_count"], here["equal_count"]);

  ASSERT_EQ(Dcloc("map build --dataset nuscenes --root " + Shared("sim") + " --drive map --out " +
                  File("other"))
                .exit_code,
            0);
  result = Dcloc("session replay " + file + " --map " + File("other"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("answers differ"));
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  result = Dcloc("session replay " + file + " --map " + Shared("map"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, ::testing::AllOf(HasSubstr(file), HasSubstr("is cut off")));
  EXPECT_EQ(Dcloc("session replay " + file).exit_code, 2) << "neither map nor server";
  EXPECT_EQ(Dcloc(At("session replay") + file + " --map " + Shared("map")).exit_code, 2);
}

TEST_F(ServerCommandsTest, ASessionThatBeganWithAFixIsReplayedToTheBit) {
  const std::string anchor = "--anchor 1.2986,103.78,10,30 ";
  Result result = Dcloc("map build " + Data() + " " + anchor + "--json --out " + File("anchored"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NEAR(nlohmann::json::parse(result.out)["anchor"]["x_axis_east_rad"], 0.5236, 1e-4);
  ASSERT_EQ(Dcloc(At("map upload") + "--map town --activate " + File("anchored")).exit_code, 0);
  const auto versions = nlohmann::json::parse(Dcloc(At("map list") + "--map town --json").out);
  EXPECT_NEAR(versions[0]["anchor"]["latitude_deg"], 1.2986, 1e-9);

  const std::string file = File("session.rec");
  result = Dcloc(Localize("--rate max --initial gnss " + anchor + "--record " + file));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  result = Dcloc("session replay " + file + " --json --map " + File("anchored"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto here = nlohmann::json::parse(result.out);
  EXPECT_GT(here["equal_count"], 100);
  EXPECT_EQ(here["different_count"], 0);
  EXPECT_EQ(Dcloc(At("session replay") + file).exit_code, 0);
  result = Dcloc("session replay " + file + " --any-map --map " + Shared("map"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("no anchor"));

  EXPECT_EQ(Dcloc(Localize("--initial gnss")).exit_code, 2) << "a fix needs an anchor";
  EXPECT_EQ(Dcloc(Localize(anchor)).exit_code, 2) << "and an anchor is for nothing else";
  result = Dcloc(Localize("--initial gnss --anchor 91,0"));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("latitude_deg is 91"));
  EXPECT_EQ(Dcloc(Localize("--initial gnss --anchor 1")).exit_code, 2);
}

TEST_F(ServerCommandsTest, AMapThatAServerMakesHasItsPlaceOnTheEarth) {
  ASSERT_EQ(Dcloc(At("map remote-build") + "--map town --activate --anchor 1.2986,103.78 " + Data())
                .exit_code,
            0);
  const Result result = Dcloc(
      At("map coverage") + "--latitude-deg 1.2986 --longitude-deg 103.78 --radius-m 5000 --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out).size(), 1U);
}

TEST_F(ServerCommandsTest, ATileOfAMapIsPrinted) {
  Upload();
  const std::string tile = At("map tile") + "--map town ";
  const std::string all = "--min-x-m -2000 --max-x-m 2000 --min-y-m -2000 --max-y-m 2000 ";
  Result result = Dcloc(tile + all + "--json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  const auto versions = nlohmann::json::parse(Dcloc(At("map list") + "--map town --json").out);
  EXPECT_EQ(json["point_count"], versions[0]["point_count"]);
  EXPECT_EQ(json["points"].size(), json["point_count"]);
  EXPECT_EQ(json["keyframes"].size(), versions[0]["keyframe_count"]);
  EXPECT_EQ(json["points"][0].size(), 4U);
  const std::vector<std::string> csv = Lines(Dcloc(tile + all + "--max-points 100").out);
  EXPECT_EQ(csv[0], "x_m,y_m,z_m,rcs_dbsm");
  EXPECT_GT(csv.size(), 30U);
  EXPECT_LE(csv.size(), 101U);
  result = Dcloc(tile + "--min-x-m 0 --max-x-m 9000 --min-y-m 0 --max-y-m 1");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("max_x_m"));
  EXPECT_EQ(Dcloc(tile + "--min-x-m 0").exit_code, 2);
}

TEST_F(ServerCommandsTest, AnOperatorRecordsTheNextSessionOfAVehicle) {
  Upload();
  const std::string file = File("session.rec");
  DclocProcess record(At("session record") + "--vehicle dcloc-localize --json --out " + file);
  while (record.Err().find("waiting") == std::string::npos) {
    ASSERT_FALSE(record.HasEnded()) << record.Err();
    std::this_thread::sleep_for(20ms);
  }
  ASSERT_EQ(Dcloc(Localize("--rate max --initial none")).exit_code, 0);
  Result result = record.Wait();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_GT(nlohmann::json::parse(result.out)["scan_count"], 100);
  result = Dcloc("session replay " + file + " --json --map " + Shared("map"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_GT(nlohmann::json::parse(result.out)["equal_count"], 100);

  ASSERT_EQ(Dcloc("map build --dataset nuscenes --root " + Shared("sim") + " --drive map --out " +
                  File("other"))
                .exit_code,
            0);
  result = Dcloc("session replay " + file + " --map " + File("other"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("is not the map of the recording")) << "known by its hash";
}

TEST_F(ServerCommandsTest, ARecordingThatIsStoppedBeforeASessionCameIsAnError) {
  DclocProcess record(At("session record") + "--vehicle nobody --out " + File("none.rec"));
  while (record.Err().find("waiting") == std::string::npos) std::this_thread::sleep_for(20ms);
  record.Signal(SIGINT);
  const Result result = record.Wait();
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("nothing recorded"));
  EXPECT_FALSE(std::filesystem::exists(File("none.rec")));
}

TEST_F(ServerCommandsTest, CtrlCKeepsWhatWasAnswered) {
  Upload();
  DclocProcess localize(Localize("--rate realtime"));
  WaitForAnswers();
  localize.Signal(SIGINT);
  const Result result = localize.Wait();
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("interrupted"));
  EXPECT_THAT(result.out, HasSubstr("scans were answered"));
  ExpectWholeLines();
}

TEST_F(ServerCommandsTest, AServerThatStopsIsAnErrorThatKeepsWhatWasAnswered) {
  Upload();
  DclocProcess localize(Localize("--rate realtime --reconnect-s 0"));
  WaitForAnswers();
  server_.reset();
  const Result result = localize.Wait();
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("dcloc: "));
  ExpectWholeLines();
}

TEST_F(ServerCommandsTest, ErrorsSayWhatIsWrongAndTouchNoFile) {
  std::ofstream(File("answers.csv")) << "old";
  Result result = Dcloc(Localize("--rate max"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("town"));
  server_.reset();
  result = Dcloc(Localize("--rate max"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr(address_));
  result = Dcloc(Localize("--rate max --tls-ca " + File("missing.pem")));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("missing.pem"));
  EXPECT_EQ(ReadText(File("answers.csv")), "old");
  EXPECT_EQ(Dcloc("map list --server nowhere").exit_code, 1);
  EXPECT_EQ(Dcloc(Localize("--rate sometimes")).exit_code, 2);
}

}  // namespace
}  // namespace dcloc
