#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/client/cli/fixtures/simulated.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

class MapCommandTest : public Simulated {};

TEST_F(MapCommandTest, BuildsAndInspectsAMap) {
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

TEST_F(MapCommandTest, TakesAPartOfADrive) {
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

TEST_F(MapCommandTest, FindsADamagedMap) {
  ASSERT_EQ(Dcloc("map build " + Dataset() + " --drive map --out " + File("b.dclm")).exit_code, 0);
  std::string bytes = ReadText(File("b.dclm"));
  bytes[bytes.size() - 100] = static_cast<char>(bytes[bytes.size() - 100] ^ 1);
  std::ofstream(File("b.dclm"), std::ios::binary) << bytes;
  const Result result = Dcloc("map inspect " + File("b.dclm"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("b.dclm"));
}

TEST_F(MapCommandTest, LeavesNothingBehindWhereItCannotWrite) {
  const std::string target = File("taken");
  std::filesystem::create_directory(target);
  const Result result = Dcloc("map build " + Dataset() + " --drive map --out " + target);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr(target));
  for (const auto& entry : std::filesystem::directory_iterator(folder_->path())) {
    EXPECT_THAT(entry.path().filename().string(), ::testing::Not(HasSubstr("taken.")));
  }
}

}  // namespace
}  // namespace dcloc
