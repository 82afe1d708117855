#include "server/maps/map_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "server/maps/upload.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/server/message_of.h"
#include "tests/server/messages.h"
#include "tests/server/test_maps.h"

namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr std::int64_t kMaxMapBytes = 1 << 20;
constexpr UploadLimits kLimits{.max_map_bytes = kMaxMapBytes};

std::string_view TextOf(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

int CountFiles(const std::filesystem::path& folder) {
  int count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    count += entry.is_regular_file() ? 1 : 0;
  }
  return count;
}

class MapStoreTest : public ::testing::Test {
 protected:
  MapStoreTest() { Reopen(); }

  void Reopen() {
    store_.reset();
    absl::StatusOr<std::unique_ptr<MapStore>> store = MapStore::Open(folder_.path());
    ASSERT_TRUE(store.ok()) << store.status();
    store_ = *std::move(store);
  }

  static UploadRequest RequestFor(const std::vector<std::byte>& bytes) {
    return {.map_name = "town",
            .size_bytes = static_cast<std::int64_t>(bytes.size()),
            .sha256 = Sha256Of(bytes),
            .activate = true};
  }

  absl::StatusOr<MapVersionRecord> Put(const std::vector<std::byte>& bytes,
                                       const UploadRequest& request) {
    absl::StatusOr<Upload> upload = Upload::Begin(*store_, request, kLimits);
    if (!upload.ok()) return upload.status();
    constexpr std::size_t kPart = 1000;
    for (std::size_t offset = 0; offset < bytes.size(); offset += kPart) {
      const auto part = TextOf(bytes).substr(offset, kPart);
      absl::Status status = upload->Append(static_cast<std::int64_t>(offset),
                                           absl::string_view(part.data(), part.size()));
      if (!status.ok()) return status;
    }
    return upload->Finish();
  }

  absl::StatusOr<MapVersionRecord> Put(const std::vector<std::byte>& bytes) {
    return Put(bytes, RequestFor(bytes));
  }

  absl::StatusOr<MapVersionRecord> PutAs(const std::string& map_name,
                                         const std::vector<std::byte>& bytes) {
    UploadRequest request = RequestFor(bytes);
    request.map_name = map_name;
    return Put(bytes, request);
  }

  int FileCount() const { return CountFiles(folder_.path() / "maps"); }
  int IncomingCount() const { return CountFiles(folder_.path() / "incoming"); }

  TemporaryFolder folder_;
  std::unique_ptr<MapStore> store_;
};

// ---- Uploads

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

// ---- Versions

TEST_F(MapStoreTest, ActivationRollsForwardAndBack) {
  ASSERT_TRUE(Put(SmallMap("first")).ok());
  UploadRequest request = RequestFor(SmallMap("second"));
  request.activate = false;
  const absl::StatusOr<MapVersionRecord> second = Put(SmallMap("second"), request);
  ASSERT_TRUE(second.ok()) << second.status();
  EXPECT_EQ(second->version, 2);
  EXPECT_FALSE(second->active);
  EXPECT_EQ(store_->Acquire("town", 0)->map->info().name, "first");
  ASSERT_TRUE(store_->Activate("town", 2).ok());
  EXPECT_EQ(store_->Acquire("town", 0)->map->info().name, "second");
  ASSERT_TRUE(store_->Activate("town", 1).ok());
  EXPECT_EQ(store_->Acquire("town", 0)->map->info().name, "first");
  EXPECT_EQ(store_->Activate("town", 9).status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(store_->Activate("country", 1).status().code(), absl::StatusCode::kNotFound);
}

TEST_F(MapStoreTest, WithoutAnActiveVersionTheErrorSaysSo) {
  UploadRequest request = RequestFor(SmallMap());
  request.activate = false;
  ASSERT_TRUE(Put(SmallMap(), request).ok());
  const absl::Status status = store_->Acquire("town", 0).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(MessageOf(status), AllOf(HasSubstr("town"), HasSubstr("active")));
  EXPECT_TRUE(store_->Acquire("town", 1).ok());
}

TEST_F(MapStoreTest, UnknownMapsAndVersionsAreNotFound) {
  ASSERT_TRUE(Put(SmallMap()).ok());
  EXPECT_EQ(store_->Acquire("country", 0).status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(store_->Acquire("town", 7).status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(store_->DeleteVersion("town", 7).code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(store_->DeleteMap("country").code(), absl::StatusCode::kNotFound);
}

TEST_F(MapStoreTest, AllWhoUseAVersionShareOneCopy) {
  ASSERT_TRUE(Put(SmallMap()).ok());
  std::vector<std::shared_ptr<const RadarMap>> maps(8);
  std::vector<std::thread> threads;
  for (auto& map : maps) {
    threads.emplace_back([&] { map = store_->Acquire("town", 0)->map; });
  }
  for (std::thread& thread : threads) thread.join();
  for (const auto& map : maps) EXPECT_EQ(map.get(), maps[0].get());
  EXPECT_EQ(store_->loaded_map_count(), 1);
  maps.clear();
  EXPECT_EQ(store_->loaded_map_count(), 1) << "the active version stays warm";
}

TEST_F(MapStoreTest, AVersionInUseIsNotDeleted) {
  ASSERT_TRUE(Put(SmallMap("first")).ok());
  ASSERT_TRUE(Put(SmallMap("second")).ok());
  std::shared_ptr<const RadarMap> in_use = store_->Acquire("town", 1)->map;
  const absl::Status status = store_->DeleteVersion("town", 1);
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(MessageOf(status), AllOf(HasSubstr("version 1"), HasSubstr("in use")));
  EXPECT_EQ(store_->DeleteMap("town").code(), absl::StatusCode::kFailedPrecondition);
  in_use.reset();
  EXPECT_TRUE(store_->DeleteVersion("town", 1).ok());
  EXPECT_EQ(FileCount(), 1);
}

TEST_F(MapStoreTest, TheActiveVersionIsNotDeletedButTheWholeMapIs) {
  ASSERT_TRUE(Put(SmallMap()).ok());
  const absl::Status status = store_->DeleteVersion("town", 1);
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(MessageOf(status), HasSubstr("active"));
  EXPECT_TRUE(store_->DeleteMap("town").ok());
  EXPECT_EQ(FileCount(), 0);
  EXPECT_EQ(store_->Acquire("town", 0).status().code(), absl::StatusCode::kNotFound);
}

TEST_F(MapStoreTest, AFileThatTwoMapsShareStaysForTheOther) {
  ASSERT_TRUE(PutAs("town", SmallMap()).ok());
  ASSERT_TRUE(PutAs("city", SmallMap()).ok());
  EXPECT_EQ(FileCount(), 1);
  ASSERT_TRUE(store_->DeleteMap("town").ok());
  EXPECT_TRUE(store_->Acquire("city", 0).ok());
  ASSERT_TRUE(store_->DeleteMap("city").ok());
  EXPECT_EQ(FileCount(), 0);
}

TEST_F(MapStoreTest, ADeletedVersionsNumberIsNotUsedAgain) {
  ASSERT_TRUE(Put(SmallMap("first")).ok());
  UploadRequest request = RequestFor(SmallMap("second"));
  request.activate = false;
  ASSERT_TRUE(Put(SmallMap("second"), request).ok());
  ASSERT_TRUE(store_->DeleteVersion("town", 2).ok());
  EXPECT_EQ(Put(SmallMap("third"))->version, 3);
}

// ---- Lists

TEST_F(MapStoreTest, ListsAreOrderedAndPaged) {
  for (const char* name : {"c", "a", "b"}) ASSERT_TRUE(PutAs(name, SmallMap()).ok());
  Catalogue& catalogue = store_->catalogue();
  const std::vector<MapRecord> page = *catalogue.ListMaps("", "", 2);
  ASSERT_EQ(page.size(), 2U);
  EXPECT_EQ(page[0].name, "a");
  EXPECT_EQ(page[1].name, "b");
  EXPECT_EQ(page[0].active_version, 1);
  EXPECT_EQ(page[0].version_count, 1);
  EXPECT_EQ(catalogue.ListMaps("", "b", 2)->at(0).name, "c");

  ASSERT_TRUE(PutAs("a", SmallMap("second")).ok());
  ASSERT_TRUE(PutAs("a", SmallMap("third")).ok());
  const auto versions = *catalogue.ListVersions("a", std::numeric_limits<std::int64_t>::max(), 2);
  ASSERT_EQ(versions.size(), 2U);
  EXPECT_EQ(versions[0].version, 3);
  EXPECT_TRUE(versions[0].active);
  EXPECT_EQ(versions[1].version, 2);
  EXPECT_FALSE(versions[1].active);
  EXPECT_EQ(catalogue.ListVersions("a", 2, 10)->size(), 1U);
}

// ---- Across restarts

TEST_F(MapStoreTest, WhatWasStoredIsThereAfterARestart) {
  const std::vector<std::byte> bytes = SmallMap();
  const MapVersionRecord before = *Put(bytes);
  Reopen();
  const absl::StatusOr<LoadedMap> loaded = store_->Acquire("town", 0);
  ASSERT_TRUE(loaded.ok()) << loaded.status();
  EXPECT_TRUE(std::ranges::equal(loaded->map->bytes(), bytes));
  EXPECT_EQ(loaded->record.create_time, before.create_time);
  EXPECT_EQ(loaded->record.info.point_count, before.info.point_count);
  EXPECT_EQ(loaded->record.info.max_map_m, before.info.max_map_m);
  EXPECT_FALSE(loaded->record.info.anchor.has_value());
}

TEST_F(MapStoreTest, TheAnchorIsKept) {
  SyntheticMap map(5, 5);
  map.info.flags |= kHasAnchorFlag;
  map.info.anchor_latitude_deg = 52.5;
  map.info.anchor_longitude_deg = 13.25;
  map.info.anchor_x_axis_east_rad = 0.5;
  ASSERT_TRUE(Put(map.Bytes()).ok());
  Reopen();
  const MapVersionRecord record = *store_->catalogue().GetVersion("town", 1);
  ASSERT_TRUE(record.info.anchor.has_value());
  EXPECT_EQ(record.info.anchor->origin.latitude_deg, 52.5);
  EXPECT_EQ(record.info.anchor->origin.longitude_deg, 13.25);
  EXPECT_EQ(record.info.anchor->x_axis_east_rad, 0.5);
}

TEST_F(MapStoreTest, ARestartRemovesWhatACrashLeftOver) {
  ASSERT_TRUE(Put(SmallMap()).ok());
  const std::filesystem::path maps = folder_.path() / "maps";
  std::ofstream(folder_.path() / "incoming" / "upload-abc") << "half a map";
  std::filesystem::create_directories(maps / "ff");
  std::ofstream(maps / "ff" / (std::string(64, 'f') + ".dcmap")) << "a file without a row";
  Reopen();
  EXPECT_EQ(IncomingCount(), 0);
  EXPECT_EQ(FileCount(), 1);
  EXPECT_EQ(store_->report().removed_leftover_count, 1);
  EXPECT_EQ(store_->report().removed_map_file_count, 1);
  EXPECT_TRUE(store_->Acquire("town", 0).ok());
}

TEST_F(MapStoreTest, AFileDamagedOnDiskIsNoticedBeforeItIsUsed) {
  ASSERT_TRUE(Put(SmallMap()).ok());
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_.path() / "maps")) {
    if (!entry.is_regular_file()) continue;
    std::fstream file(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(-60, std::ios::end);
    file.put('\x7f');
  }
  Reopen();
  EXPECT_EQ(store_->Acquire("town", 0).status().code(), absl::StatusCode::kDataLoss);
}

TEST_F(MapStoreTest, OneFolderServesOneStore) {
  const absl::Status status = MapStore::Open(folder_.path()).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(MessageOf(status), HasSubstr(folder_.path().string()));
}

TEST_F(MapStoreTest, ACatalogueThatIsNoDatabaseIsAnError) {
  store_.reset();
  std::filesystem::remove(folder_.path() / "catalogue.sqlite-wal");
  std::ofstream(folder_.path() / "catalogue.sqlite", std::ios::trunc) << std::string(4096, 'x');
  EXPECT_EQ(MapStore::Open(folder_.path()).status().code(), absl::StatusCode::kDataLoss);
}

TEST(MapStoreOpenTest, AFolderThatCannotBeMadeIsAnErrorThatNamesIt) {
  const absl::Status status = MapStore::Open("/proc/nowhere").status();
  EXPECT_FALSE(status.ok());
  EXPECT_THAT(MessageOf(status), HasSubstr("/proc/nowhere"));
}

}  // namespace
}  // namespace dcloc::server
