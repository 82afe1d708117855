#include "server/maps/store/map_bucket.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "server/maps/store/map_folder.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/messages.h"
#include "tests/server/fixtures/s3_stub.h"
#include "tests/server/fixtures/test_maps.h"

namespace dcloc::server {
namespace {

using Kind = S3Fault::Kind;

class MapBucketTest : public ::testing::Test {
 protected:
  absl::Status Keep() { return bucket_.Keep(folder_.Write("upload", bytes_), sha256_); }

  bool UploadIsThere() const { return std::filesystem::exists(folder_.path() / "upload"); }

  const std::vector<std::byte> bytes_ = SmallMap();
  const std::string sha256_ = Sha256Of(bytes_);
  TemporaryFolder folder_;
  S3Stub stub_;
  MapBucket bucket_{*ObjectStore::Open(stub_.Options())};
};

TEST_F(MapBucketTest, FilesHaveTheNamesThatTheyHaveInAFolder) {
  ASSERT_TRUE(Keep().ok());
  EXPECT_TRUE(stub_.objects().contains(MapFolder::PathIn("site/maps", sha256_).string()));
}

TEST_F(MapBucketTest, AnUploadThatTheServiceForgetsOrSpoilsIsNotTaken) {
  stub_.FailNext({.kind = Kind::kForget}, 1, "PUT");
  EXPECT_TRUE(absl::IsUnavailable(Keep()));
  EXPECT_TRUE(UploadIsThere()) << "to be tried again";
  stub_.FailNext({.kind = Kind::kWrongBytes}, 1, "GET");
  EXPECT_TRUE(absl::IsUnavailable(Keep()));
  EXPECT_TRUE(Keep().ok());
  EXPECT_FALSE(UploadIsThere());
}

TEST_F(MapBucketTest, BytesThatChangeOnTheirWayAreNeverServed) {
  ASSERT_TRUE(Keep().ok());
  stub_.FailNext({.kind = Kind::kWrongBytes}, 1, "GET");
  EXPECT_EQ(*bucket_.Read(sha256_), bytes_) << "read once more";
  stub_.FailNext({.kind = Kind::kWrongBytes}, 2, "GET");
  EXPECT_TRUE(absl::IsDataLoss(bucket_.Read(sha256_).status()));
}

TEST_F(MapBucketTest, WhileItIsAwayNothingIsLostAndAllRecovers) {
  ASSERT_TRUE(Keep().ok());
  stub_.Stop();
  EXPECT_TRUE(absl::IsUnavailable(Keep()));
  EXPECT_TRUE(UploadIsThere());
  EXPECT_TRUE(absl::IsUnavailable(bucket_.Read(sha256_).status()));
  EXPECT_TRUE(absl::IsUnavailable(bucket_.SizeOf(sha256_).status()));
  EXPECT_TRUE(absl::IsUnavailable(bucket_.List().status()));
  EXPECT_TRUE(absl::IsUnavailable(bucket_.Remove(sha256_)));
  EXPECT_TRUE(absl::IsUnavailable(bucket_.RemoveExpiredQuarantine({}, {}).status()));
  stub_.Start();
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  EXPECT_EQ(*bucket_.Read(sha256_), bytes_);
  EXPECT_TRUE(Keep().ok());
}

TEST_F(MapBucketTest, AFileThatCannotBeCopiedIsNotSetAside) {
  ASSERT_TRUE(Keep().ok());
  stub_.FailNext({.kind = Kind::kForget}, 1, "PUT");
  EXPECT_TRUE(absl::IsUnavailable(bucket_.Quarantine(sha256_)));
  EXPECT_EQ(*bucket_.Read(sha256_), bytes_);
}

}  // namespace
}  // namespace dcloc::server
