#include "server/maps/store/map_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/messages.h"
#include "tests/server/fixtures/places.h"
#include "tests/server/fixtures/test_maps.h"

// What each storage of map files promises.
namespace dcloc::server {
namespace {

using std::chrono::hours;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

class MapFilesTest : public ::testing::TestWithParam<MapFilesImplementation> {
 protected:
  void SetUp() override {
    if (!GetParam().is_there) GTEST_SKIP() << GetParam().name << " is not installed";
    place_ = GetParam().make_place();
    files_ = place_->Open();
  }

  absl::Status Keep(const std::vector<std::byte>& bytes) {
    const std::filesystem::path path = folder_.Write("upload", bytes);
    absl::Status status = files_->Keep(path, Sha256Of(bytes));
    EXPECT_EQ(std::filesystem::exists(path), !status.ok()) << "it is moved";
    return status;
  }

  const std::vector<std::byte> first_ = SmallMap("first");
  const std::vector<std::byte> second_ = SmallMap("second", 40);
  const std::string sha256_ = Sha256Of(first_);
  TemporaryFolder folder_;
  std::unique_ptr<MapFilesPlace> place_;
  std::unique_ptr<MapFiles> files_;
};

TEST_P(MapFilesTest, WhatIsKeptIsReadByEachProcess) {
  ASSERT_TRUE(Keep(first_).ok());
  ASSERT_TRUE(Keep(second_).ok());
  const auto other = place_->Open();
  for (MapFiles* files : {files_.get(), other.get()}) {
    EXPECT_EQ(*files->Read(sha256_), first_);
    EXPECT_EQ(*files->Read(sha256_), first_) << "and again";
    EXPECT_EQ((*files->Open(Sha256Of(second_)))->info().name, "second");
    EXPECT_EQ(*files->SizeOf(sha256_), static_cast<std::int64_t>(first_.size()));
    EXPECT_THAT(*files->List(), UnorderedElementsAre(sha256_, Sha256Of(second_)));
  }
}

TEST_P(MapFilesTest, AMapThatIsOpenOutlivesItsFile) {
  ASSERT_TRUE(Keep(first_).ok());
  const auto map = *files_->Open(sha256_);
  ASSERT_TRUE(files_->Remove(sha256_).ok());
  EXPECT_TRUE(map->Verify().ok());
  EXPECT_TRUE(absl::IsNotFound(files_->Read(sha256_).status()));
  EXPECT_THAT(*files_->List(), IsEmpty());
}

TEST_P(MapFilesTest, WhatIsMissingIsNotFound) {
  EXPECT_TRUE(absl::IsNotFound(files_->Read(sha256_).status()));
  EXPECT_TRUE(absl::IsNotFound(files_->Open(sha256_).status()));
  EXPECT_TRUE(absl::IsNotFound(files_->Check(sha256_, [](std::size_t) { return true; })));
  EXPECT_TRUE(absl::IsNotFound(files_->Quarantine(sha256_)));
  EXPECT_EQ(*files_->SizeOf(sha256_), 0);
  EXPECT_TRUE(files_->Remove(sha256_).ok());
  EXPECT_THAT(*files_->List(), IsEmpty());
  EXPECT_EQ(*files_->QuarantinedCount(), 0);
}

TEST_P(MapFilesTest, OtherBytesAreDataLossAndKeepingTheFileMendsIt) {
  ASSERT_TRUE(Keep(first_).ok());
  std::vector<std::byte> spoilt = first_;
  spoilt.back() ^= std::byte{1};
  const std::vector<std::byte> cut(first_.begin(), first_.end() - 9);
  for (const std::vector<std::byte>& bytes : {spoilt, cut, std::vector<std::byte>{}}) {
    place_->Spoil(sha256_, bytes);
    EXPECT_TRUE(absl::IsDataLoss(files_->Read(sha256_).status()));
    EXPECT_TRUE(absl::IsDataLoss(files_->Open(sha256_).status()));
    EXPECT_TRUE(absl::IsDataLoss(files_->Check(sha256_, [](std::size_t) { return true; })));
  }
  ASSERT_TRUE(Keep(first_).ok());
  EXPECT_EQ(*files_->Read(sha256_), first_);
}

TEST_P(MapFilesTest, ACheckReadsAllAndCanBeStopped) {
  ASSERT_TRUE(Keep(second_).ok());
  std::size_t sum_bytes = 0;
  const auto add = [&](std::size_t size_bytes) {
    sum_bytes += size_bytes;
    return true;
  };
  EXPECT_TRUE(files_->Check(Sha256Of(second_), add).ok());
  EXPECT_EQ(sum_bytes, second_.size());
  EXPECT_TRUE(
      absl::IsCancelled(files_->Check(Sha256Of(second_), [](std::size_t) { return false; })));
}

TEST_P(MapFilesTest, WhatIsSetAsideIsRemovedAfterTheTimeThatWasServed) {
  ASSERT_TRUE(Keep(first_).ok());
  ASSERT_TRUE(Keep(second_).ok());
  ASSERT_TRUE(files_->Quarantine(sha256_).ok());
  EXPECT_THAT(*files_->List(), ElementsAre(Sha256Of(second_)));
  EXPECT_TRUE(absl::IsNotFound(files_->Read(sha256_).status()));
  EXPECT_EQ(*files_->QuarantinedCount(), 1);
  EXPECT_EQ(*files_->RemoveExpiredQuarantine(hours(5), hours(3)), 0) << "it has just come";
  EXPECT_EQ(*files_->RemoveExpiredQuarantine(hours(2), hours(3)), 0);
  files_ = place_->Open();
  EXPECT_EQ(*files_->RemoveExpiredQuarantine(hours(1), hours(3)), 1) << "time adds up";
  EXPECT_EQ(*files_->QuarantinedCount(), 0);
  EXPECT_EQ(*files_->Read(Sha256Of(second_)), second_);
}

TEST_P(MapFilesTest, WhatIsSetAsideOnceMoreBeginsAnew) {
  ASSERT_TRUE(Keep(first_).ok());
  ASSERT_TRUE(files_->Quarantine(sha256_).ok());
  EXPECT_EQ(*files_->RemoveExpiredQuarantine(hours(1), hours(3)), 0);
  EXPECT_EQ(*files_->RemoveExpiredQuarantine(hours(2), hours(3)), 0);
  ASSERT_TRUE(Keep(first_).ok());
  ASSERT_TRUE(files_->Quarantine(sha256_).ok());
  EXPECT_EQ(*files_->RemoveExpiredQuarantine(hours(2), hours(3)), 0);
  EXPECT_EQ(*files_->QuarantinedCount(), 1);
}

INSTANTIATE_TEST_SUITE_P(Each, MapFilesTest, ::testing::ValuesIn(MapFilesImplementations()),
                         NameOfImplementation());

}  // namespace
}  // namespace dcloc::server
