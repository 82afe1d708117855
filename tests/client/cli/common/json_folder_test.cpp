#include "client/cli/common/json_folder.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/client/datasets/temp_folder.h"

namespace dcloc::cli {
namespace {

TEST(JsonFolderTest, ResultsOfAnotherProgramAreNotThisOnes) {
  const TempFolder folder;
  const JsonFolder results(folder.path(), "program 1");
  EXPECT_FALSE(results.Load("run").has_value());
  ASSERT_TRUE(results.Save("run", {{"wrong", 0}}).ok());
  EXPECT_EQ(results.Load("run"), (nlohmann::json{{"wrong", 0}}));
  EXPECT_FALSE(JsonFolder(folder.path(), "program 2").Load("run").has_value());
  folder.Write("run.json", "{\"fingerprint\": \"program 1\", \"outcome\": ");
  EXPECT_FALSE(results.Load("run").has_value());
  EXPECT_EQ(ProgramHash(), ProgramHash());
  EXPECT_EQ(ProgramHash().size(), 16U);
}

}  // namespace
}  // namespace dcloc::cli
