#include "server/maps/store/kept_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/messages.h"
#include "tests/server/fixtures/s3_stub.h"

// What each storage of files beside the maps promises.
namespace dcloc::server {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;

class KeptFilesTest : public ::testing::TestWithParam<bool> {
 protected:
  KeptFilesTest() {
    if (GetParam()) {
      files_ = std::make_unique<KeptObjects>(*ObjectStore::Open(stub_.Options()), "builds/");
    } else {
      files_ = *KeptFolder::Open(folder_.path() / "builds");
    }
  }

  absl::Status Keep(const std::string& name) {
    const std::filesystem::path path = folder_.Write("local", bytes_);
    absl::Status status = files_->Keep(path, name, Sha256Of(bytes_));
    EXPECT_EQ(std::filesystem::exists(path), !status.ok()) << "it is moved";
    return status;
  }

  std::string Fetched() const {
    std::ifstream file(folder_.path() / "fetched", std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  absl::Status Fetch(const std::string& name, const std::string& sha256) {
    return files_->Fetch(name, sha256, folder_.path() / "fetched");
  }

  const std::vector<std::byte> bytes_ = std::vector<std::byte>(5'000'000, std::byte{7});
  TemporaryFolder folder_;
  S3Stub stub_;
  std::unique_ptr<KeptFiles> files_;
};

TEST_P(KeptFilesTest, WhatIsKeptCanBeFetchedUntilItIsRemoved) {
  EXPECT_THAT(*files_->List(), IsEmpty());
  ASSERT_TRUE(Keep("one").ok());
  EXPECT_THAT(*files_->List(), ElementsAre(Pair("one", 5'000'000)));
  ASSERT_TRUE(Fetch("one", Sha256Of(bytes_)).ok());
  EXPECT_EQ(Fetched(), std::string(5'000'000, '\7'));
  EXPECT_TRUE(files_->Remove("one").ok());
  EXPECT_TRUE(files_->Remove("one").ok()) << "it is gone already";
  EXPECT_THAT(*files_->List(), IsEmpty());
  EXPECT_EQ(Fetch("one", Sha256Of(bytes_)).code(), absl::StatusCode::kNotFound);
}

TEST_P(KeptFilesTest, OtherBytesAreNoticed) {
  ASSERT_TRUE(Keep("one").ok());
  EXPECT_EQ(Fetch("one", std::string(64, 'a')).code(), absl::StatusCode::kDataLoss);
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "fetched"));
}

INSTANTIATE_TEST_SUITE_P(Files, KeptFilesTest, ::testing::Bool(), [](const auto& instance) {
  return instance.param ? "Objects" : "Folder";
});

}  // namespace
}  // namespace dcloc::server
