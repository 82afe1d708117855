#include "client/cli/common/dataset_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace dcloc::cli {
namespace {

TEST(DatasetOptionsTest, AThirdDatasetIsNotReadAsOneOfTheTwo) {
  const absl::Status status = ReadDrive({.format = "kitti", .root = "."}, {.name = "a"}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), ::testing::HasSubstr("'kitti'"));
}

TEST(DatasetOptionsTest, TheCommandLineTakesTheFormatsThatThereAre) {
  for (const auto& [name, format] : kDatasetFormatNames) {
    CLI::App app;
    DatasetArguments arguments;
    AddDatasetOptions(app, arguments);
    app.parse(std::string("--root . --dataset ") + name);
    EXPECT_EQ(arguments.format, name);
  }
  CLI::App app;
  DatasetArguments arguments;
  AddDatasetOptions(app, arguments);
  EXPECT_THROW(app.parse("--root . --dataset kitti"), CLI::ParseError);
}

}  // namespace
}  // namespace dcloc::cli
