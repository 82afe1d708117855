#include "client/cli/common/output_file.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/client/datasets/temp_folder.h"

namespace dcloc::cli {
namespace {

TEST(OutputFileTest, WhatIsThereIsReplacedOnlyByForce) {
  const TempFolder folder;
  const std::string old = folder.Write("old.dclm", "a map");
  const std::string other = folder.path() / "new.dclm";
  EXPECT_TRUE(CheckOutputFiles({.paths = {other, ""}}).ok());
  EXPECT_EQ(CheckOutputFiles({.paths = {other, old}}).code(), absl::StatusCode::kAlreadyExists);
  EXPECT_TRUE(CheckOutputFiles({.paths = {other, old}, .force = true}).ok());
}

TEST(OutputFileTest, TwoOutputsOfOnePathAreRefusedHoweverItIsWritten) {
  const TempFolder folder;
  const std::string path = folder.path() / "a.dclm";
  const std::string same = folder.path() / "x" / ".." / "a.dclm";
  EXPECT_EQ(CheckOutputFiles({.paths = {path, same}, .force = true}).code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace dcloc::cli
