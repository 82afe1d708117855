#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "tests/server/fixtures/message_of.h"
#include "tests/server/maps/store/map_store_case.h"

// What an upload must be to become a version.
namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST_F(MapStoreTest, AnUploadBecomesAVersion) {
  const std::vector<std::byte> bytes = SmallMap();
  const absl::StatusOr<MapVersionRecord> record = Put(bytes);
  ASSERT_TRUE(record.ok()) << record.status();
  EXPECT_EQ(record->map_name, "town");
  EXPECT_EQ(record->version, 1);
  EXPECT_TRUE(record->active);
  EXPECT_EQ(record->sha256, Sha256Of(bytes));
  EXPECT_EQ(record->info.size_bytes, bytes.size());
  EXPECT_EQ(record->info.keyframe_count, 12U);
  EXPECT_EQ(record->info.name, "spiral");
  EXPECT_EQ(IncomingCount(), 0);

  const absl::StatusOr<LoadedMap> loaded = store_->Acquire("town", 0);
  ASSERT_TRUE(loaded.ok()) << loaded.status();
  EXPECT_TRUE(std::ranges::equal(loaded->map->bytes(), bytes));
}

TEST_F(MapStoreTest, AWrongHashIsRefused) {
  const std::vector<std::byte> bytes = SmallMap();
  UploadRequest request = RequestFor(bytes);
  request.sha256 = Sha256Of(SmallMap("other"));
  const absl::Status status = Put(bytes, request).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(MessageOf(status), AllOf(HasSubstr("header.sha256"), HasSubstr(request.sha256),
                                       HasSubstr(Sha256Of(bytes))));
  EXPECT_EQ(store_->catalogue().GetMap("town").status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(IncomingCount(), 0);
  EXPECT_EQ(FileCount(), 0);
}

TEST_F(MapStoreTest, ATruncatedUploadIsRefused) {
  const std::vector<std::byte> bytes = SmallMap();
  std::vector<std::byte> part(bytes.begin(), bytes.end() - 100);
  const absl::Status status = Put(part, RequestFor(bytes)).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(MessageOf(status), AllOf(HasSubstr(std::to_string(part.size())),
                                       HasSubstr(std::to_string(bytes.size()))));
  EXPECT_EQ(IncomingCount(), 1) << "the rest may still come";
}

TEST_F(MapStoreTest, AFlippedByteIsRefusedThoughTheHashIsRight) {
  std::vector<std::byte> bytes = SmallMap();
  bytes[bytes.size() - 60] ^= std::byte{1};  // in a point, which only Verify reads
  const absl::Status status = Put(bytes).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(MessageOf(status), HasSubstr("no intact map"));
  EXPECT_EQ(MessageOf(status).find(folder_.path().string()), std::string::npos)
      << "paths of the server's machine are nothing to a client: " << status;
  EXPECT_EQ(FileCount(), 0);
}

TEST_F(MapStoreTest, WhatIsNoMapIsRefused) {
  const std::vector<std::byte> bytes(5000, std::byte{'x'});
  EXPECT_EQ(Put(bytes).status().code(), absl::StatusCode::kDataLoss);
}

TEST_F(MapStoreTest, BadHeadersAreRefusedByName) {
  const std::vector<std::byte> bytes = SmallMap();
  const auto error_of = [&](auto spoil) {
    UploadRequest request = RequestFor(bytes);
    spoil(request);
    const absl::Status status = Upload::Begin(*store_, request, kLimits).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
    return MessageOf(status);
  };
  EXPECT_THAT(error_of([](auto& r) { r.map_name = "A town"; }), HasSubstr("header.map_name"));
  EXPECT_THAT(error_of([](auto& r) { r.map_name = ".."; }), HasSubstr("header.map_name"));
  EXPECT_THAT(error_of([](auto& r) { r.size_bytes = 0; }), HasSubstr("header.size_bytes is 0"));
  EXPECT_THAT(error_of([](auto& r) { r.size_bytes = -7; }), HasSubstr("-7"));
  EXPECT_THAT(error_of([](auto& r) { r.size_bytes = kMaxMapBytes + 1; }),
              HasSubstr(std::to_string(kMaxMapBytes)));
  EXPECT_THAT(error_of([](auto& r) { r.sha256 = "abc"; }), HasSubstr("header.sha256"));
  EXPECT_THAT(error_of([](auto& r) { r.sha256 = "../" + std::string(61, 'a'); }),
              HasSubstr("header.sha256"));
}

TEST_F(MapStoreTest, ATenantsStorageIsBounded) {
  const std::vector<std::byte> bytes = SmallMap();
  const auto size = static_cast<std::int64_t>(bytes.size());
  ASSERT_TRUE(Put(bytes).ok());
  const UploadLimits limits{.max_map_bytes = kMaxMapBytes, .max_tenant_bytes = 2 * size - 1};
  const std::vector<std::byte> other = SmallMap("other!");
  ASSERT_EQ(other.size(), bytes.size());
  const absl::Status status = Upload::Begin(*store_, RequestFor(other), limits).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(MessageOf(status), HasSubstr("max_tenant_storage_mib"));
  UploadRequest request = RequestFor(other);
  request.tenant = "acme";
  EXPECT_TRUE(Upload::Begin(*store_, request, limits).ok()) << "another tenant's maps do not count";
  const UploadLimits enough{.max_map_bytes = kMaxMapBytes, .max_tenant_bytes = 2 * size};
  EXPECT_TRUE(Upload::Begin(*store_, RequestFor(other), enough).ok());
}

TEST_F(MapStoreTest, ChunksMustFollowEachOther) {
  const std::vector<std::byte> bytes = SmallMap();
  absl::StatusOr<Upload> upload = Upload::Begin(*store_, RequestFor(bytes), kLimits);
  ASSERT_TRUE(upload.ok());
  ASSERT_TRUE(upload->Append(0, "abcd").ok());
  const absl::Status gap = upload->Append(5, "x");
  EXPECT_EQ(gap.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(MessageOf(gap), AllOf(HasSubstr("chunk.offset_bytes is 5"), HasSubstr("4")));
  const absl::Status beyond = upload->Append(4, std::string(bytes.size(), 'x'));
  EXPECT_EQ(beyond.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(MessageOf(beyond), HasSubstr("chunk.data"));
}

TEST_F(MapStoreTest, TheSameFileTwiceIsOneVersion) {
  const std::vector<std::byte> bytes = SmallMap();
  ASSERT_TRUE(Put(bytes).ok());
  const absl::StatusOr<MapVersionRecord> again = Put(bytes);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->version, 1);
  EXPECT_EQ(store_->catalogue().GetMap("town")->version_count, 1);
}

}  // namespace
}  // namespace dcloc::server
