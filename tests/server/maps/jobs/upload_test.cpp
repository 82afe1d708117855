#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/server/maps/store/map_store_fixture.h"

// Uploads that break off and go on.
namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class MapUploadTest : public StoreFixture {
 protected:
  MapUploadTest() : half_(bytes_.size() / 2) {}

  Upload Begin() { return Begin(RequestFor(bytes_)); }
  Upload Begin(const UploadRequest& request) {
    absl::StatusOr<Upload> upload = Upload::Begin(*store_, request, kNoLimits);
    EXPECT_TRUE(upload.ok()) << upload.status();
    return *std::move(upload);
  }

  void SendHalf() {
    Upload upload = Begin();
    ASSERT_TRUE(AppendAll(upload, bytes_, 0, half_).ok());
  }

  std::int64_t DurableSize(const std::string& tenant = "") {
    return *store_->incoming().DurableSize(tenant, Sha256Of(bytes_));
  }

  std::filesystem::path Incoming() const {
    return folder_.path() / "incoming" / ("@" + Sha256Of(bytes_) + ".part");
  }

  const std::vector<std::byte> bytes_ = SmallMap("long", 2000);
  const std::size_t half_;
};

TEST_F(MapUploadTest, GoesOnWhereItBrokeOff) {
  EXPECT_EQ(DurableSize(), 0);
  SendHalf();
  EXPECT_EQ(DurableSize(), static_cast<std::int64_t>(half_));
  Upload upload = Begin();
  ASSERT_TRUE(AppendAll(upload, bytes_, half_).ok());
  const absl::StatusOr<MapVersionRecord> record = upload.Finish();
  ASSERT_TRUE(record.ok()) << record.status();
  EXPECT_TRUE(record->active);
  EXPECT_TRUE(std::ranges::equal(store_->Acquire("town", 0)->map->bytes(), bytes_));
  EXPECT_EQ(DurableSize(), 0);
  EXPECT_EQ(*store_->incoming().Count(), 0);
}

TEST_F(MapUploadTest, GoesOnAfterARestart) {
  SendHalf();
  Reopen();
  EXPECT_EQ(store_->report().unfinished_upload_count, 1);
  EXPECT_EQ(DurableSize(), static_cast<std::int64_t>(half_));
  Upload upload = Begin();
  ASSERT_TRUE(AppendAll(upload, bytes_, half_).ok());
  EXPECT_TRUE(upload.Finish().ok());
}

TEST_F(MapUploadTest, WhatIsThereMayBeSentAgain) {
  SendHalf();
  for (const std::size_t begin : {half_ - 7, std::size_t{0}}) {
    Upload upload = Begin();
    ASSERT_TRUE(AppendAll(upload, bytes_, begin, begin + 10).ok());
    EXPECT_EQ(DurableSize(), static_cast<std::int64_t>(begin + 10));
  }
  Upload upload = Begin();
  ASSERT_TRUE(AppendAll(upload, bytes_, 10).ok());
  EXPECT_TRUE(upload.Finish().ok());
}

TEST_F(MapUploadTest, AGapIsRefusedByName) {
  SendHalf();
  Upload upload = Begin();
  const auto offset = static_cast<std::int64_t>(half_) + 1;
  const absl::Status gap = upload.Append(offset, "x");
  EXPECT_EQ(gap.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(gap.message()),
              AllOf(HasSubstr("chunk.offset_bytes is " + std::to_string(offset)),
                    HasSubstr(std::to_string(half_))));
  EXPECT_EQ(Begin().Append(-1, "x").code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(DurableSize(), static_cast<std::int64_t>(half_)) << "nothing was lost by it";
}

TEST_F(MapUploadTest, ASecondUploadOfTheFileTakesOver) {
  Upload first = Begin();
  ASSERT_TRUE(AppendAll(first, bytes_, 0, half_).ok());
  Upload second = Begin();
  ASSERT_TRUE(AppendAll(second, bytes_, half_, half_ + 1).ok());
  const absl::Status status = first.Append(static_cast<std::int64_t>(half_), "garbage");
  EXPECT_EQ(status.code(), absl::StatusCode::kAborted);
  EXPECT_EQ(first.Finish().status().code(), absl::StatusCode::kAborted);
  ASSERT_TRUE(AppendAll(second, bytes_, half_ + 1).ok());
  EXPECT_TRUE(second.Finish().ok());
}

TEST_F(MapUploadTest, WhatIsCompleteNeedsNoMoreChunks) {
  {
    Upload upload = Begin();
    ASSERT_TRUE(AppendAll(upload, bytes_).ok());
  }
  EXPECT_TRUE(Begin().Finish().ok());
}

TEST_F(MapUploadTest, AFileThatTheTenantHasNeedsNoChunks) {
  Put(bytes_);
  EXPECT_TRUE(*store_->HasStored("", Sha256Of(bytes_)));
  UploadRequest request = RequestFor(bytes_);
  request.map_name = "city";
  const absl::StatusOr<MapVersionRecord> record = Begin(request).Finish();
  ASSERT_TRUE(record.ok()) << record.status();
  EXPECT_EQ(record->map_name, "city");
  EXPECT_EQ(record->info.keyframe_count, 2000U);
  EXPECT_TRUE(store_->Acquire("city", 0).ok());
}

TEST_F(MapUploadTest, ATenantsFilesAreNothingToAnother) {
  Put(bytes_);
  EXPECT_FALSE(*store_->HasStored("acme/", Sha256Of(bytes_)));
  UploadRequest request = RequestFor(bytes_);
  request.tenant = "acme";
  const absl::Status status = Begin(request).Finish().status();
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss)
      << "who knows a hash must not get the file: " << status;
  {
    Upload upload = Begin(request);
    ASSERT_TRUE(AppendAll(upload, bytes_, 0, half_).ok());
  }
  EXPECT_EQ(DurableSize("acme"), static_cast<std::int64_t>(half_));
  EXPECT_EQ(DurableSize(), 0);
}

TEST_F(MapUploadTest, DamageOnTheWayIsNoticedAndTheNextUploadBeginsAnew) {
  SendHalf();
  std::fstream(Incoming(), std::ios::in | std::ios::out | std::ios::binary).put('?');
  Upload upload = Begin();
  ASSERT_TRUE(AppendAll(upload, bytes_, half_).ok());
  EXPECT_EQ(upload.Finish().status().code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(DurableSize(), 0);
}

TEST_F(MapUploadTest, StaleOnesAreRemovedAfterTheTimeout) {
  using std::chrono::hours;
  SendHalf();
  EXPECT_EQ(*store_->RemoveStaleUploads(hours(25)), 0) << "it may have come at the end of them";
  EXPECT_EQ(*store_->RemoveStaleUploads(hours(23)), 0);
  {
    const Upload under_way = Begin();
    EXPECT_EQ(*store_->RemoveStaleUploads(hours(25)), 0);
  }
  EXPECT_EQ(*store_->RemoveStaleUploads(hours(1)), 0);
  EXPECT_EQ(*store_->RemoveStaleUploads(hours(23)), 0);
  EXPECT_EQ(*store_->RemoveStaleUploads(hours(1)), 1);
  EXPECT_EQ(DurableSize(), 0);
}

TEST_F(MapUploadTest, ARestartAndAJumpingClockMakeNoneOlder) {
  using std::chrono::file_clock;
  using std::chrono::hours;
  SendHalf();
  EXPECT_EQ(*store_->RemoveStaleUploads(hours(1)), 0);
  EXPECT_EQ(*store_->RemoveStaleUploads(hours(23)), 0);
  std::filesystem::last_write_time(Incoming(), file_clock::now() - hours(24 * 365));
  Reopen();
  EXPECT_EQ(store_->report().unfinished_upload_count, 1);
  EXPECT_EQ(*store_->RemoveStaleUploads(hours(1)), 1) << "what was served before counts";
}

TEST_F(MapUploadTest, UnfinishedOnesCountForTheTenantsStorage) {
  SendHalf();
  const std::vector<std::byte> other = SmallMap();
  const auto size = static_cast<std::int64_t>(other.size());
  const auto limits = [&](std::int64_t max) {
    return UploadLimits{.max_map_bytes = max, .max_tenant_bytes = max};
  };
  const auto enough = static_cast<std::int64_t>(half_) + size;
  EXPECT_TRUE(Upload::Begin(*store_, RequestFor(other), limits(enough)).ok());
  const absl::Status status =
      Upload::Begin(*store_, RequestFor(other), limits(enough - 1)).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(status.message()), HasSubstr("unfinished uploads"));
  const auto whole = static_cast<std::int64_t>(bytes_.size());
  EXPECT_TRUE(Upload::Begin(*store_, RequestFor(bytes_), limits(whole)).ok())
      << "its own beginning does not count twice";
}

TEST_F(MapUploadTest, AFileThatSeveralVersionsHaveCountsOnce) {
  ASSERT_EQ(Put(bytes_), 1);
  const auto size = static_cast<std::int64_t>(bytes_.size());
  const UploadLimits full{.max_map_bytes = size, .max_tenant_bytes = size};
  UploadRequest request = RequestFor(bytes_);
  request.map_name = "city";
  absl::StatusOr<Upload> upload = Upload::Begin(*store_, request, full);
  ASSERT_TRUE(upload.ok()) << "it takes no more room: " << upload.status();
  ASSERT_TRUE(upload->Finish().ok());
  EXPECT_EQ(*store_->catalogue().SizeOfMaps(""), size);
  EXPECT_EQ(Upload::Begin(*store_, RequestFor(SmallMap()), full).status().code(),
            absl::StatusCode::kResourceExhausted);
  request.tenant = "acme";
  EXPECT_TRUE(Upload::Begin(*store_, request, full).ok()) << "another tenant's storage";
}

TEST_F(MapUploadTest, ALostFileIsReportedAndMendedByUploadingItAgain) {
  ASSERT_EQ(Put(bytes_), 1);
  std::filesystem::resize_file(FileOf(bytes_), half_);
  Reopen();
  EXPECT_THAT(store_->report().broken_files, ::testing::ElementsAre(Sha256Of(bytes_)));
  const absl::Status status = store_->Acquire("town", 0).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(std::string(status.message()).find(folder_.path().string()), std::string::npos);
  EXPECT_FALSE(*store_->HasStored("", Sha256Of(bytes_)));
  EXPECT_EQ(Put(bytes_), 1) << "the version that has the file";
  EXPECT_TRUE(store_->Acquire("town", 0).ok());
  std::filesystem::remove(FileOf(bytes_));
  Reopen();
  EXPECT_EQ(store_->report().broken_files.size(), 1U);
  EXPECT_EQ(store_->Acquire("town", 0).status().code(), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace dcloc::server
