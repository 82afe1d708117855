#include "server/maps/store/map_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "server/base/sqlite.h"
#include "tests/server/fixtures/message_of.h"
#include "tests/server/maps/store/map_store_case.h"

namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

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

TEST_F(MapStoreTest, WhatWasJustVerifiedIsNotReadAgain) {
  const std::vector<std::byte> bytes = SmallMap();
  const std::string path = folder_.Write("arrived", bytes);
  const std::shared_ptr<const RadarMap> map = *RadarMap::Open(path);
  absl::StatusOr<LoadedMap> added = store_->Add(path, "town", Sha256Of(bytes), map);
  ASSERT_TRUE(added.ok()) << added.status();
  absl::StatusOr<LoadedMap> loaded = store_->Acquire("town", 1);
  ASSERT_TRUE(loaded.ok()) << loaded.status();
  EXPECT_TRUE(loaded->was_in_memory);
  EXPECT_EQ(loaded->map.get(), map.get());
  added = absl::CancelledError();
  loaded = absl::CancelledError();
  EXPECT_EQ(store_->loaded_map_count(), 0) << "it is kept for those who use it only";
  EXPECT_FALSE(store_->Acquire("town", 1)->was_in_memory);
}

TEST_F(MapStoreTest, AllWhoUseAVersionShareOneCopy) {
  ASSERT_TRUE(Put(SmallMap()).ok());
  std::vector<std::shared_ptr<const RadarMap>> maps(8);
  std::vector<std::thread> threads;
  threads.reserve(maps.size());
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

TEST_F(MapStoreTest, ARestartSetsAsideWhatACrashLeftOver) {
  ASSERT_TRUE(Put(SmallMap()).ok());
  const std::filesystem::path maps = folder_.path() / "maps";
  ASSERT_TRUE(store_->catalogue().AddLooseFile(std::string(64, 'f')).ok());
  std::ofstream(folder_.path() / "incoming" / "upload-abc") << "half a map";
  std::filesystem::create_directories(maps / "ff");
  std::ofstream(maps / "ff" / (std::string(64, 'f') + ".dcmap")) << "a file without a row";
  Reopen();
  EXPECT_EQ(IncomingCount(), 0);
  EXPECT_EQ(FileCount(), 1);
  EXPECT_EQ(store_->report().removed_leftover_count, 1);
  EXPECT_EQ(store_->report().quarantined_file_count, 1);
  EXPECT_EQ(*store_->files().QuarantinedCount(), 1);
  EXPECT_TRUE(store_->Acquire("town", 0).ok());
}

TEST_F(MapStoreTest, WhatAFileBecomesWhileItIsUsedDoesNotMatter) {
  const std::vector<std::byte> bytes = SmallMap();
  ASSERT_TRUE(Put(bytes).ok());
  Reopen();
  const absl::StatusOr<LoadedMap> in_use = store_->Acquire("town", 0);
  ASSERT_TRUE(in_use.ok()) << in_use.status();
  std::filesystem::resize_file(FileOf(bytes), 10);
  EXPECT_TRUE(std::ranges::equal(in_use->map->bytes(), bytes));
  EXPECT_TRUE(in_use->map->Verify().ok());
}

TEST_F(MapStoreTest, ErrorsNameNoPathOfTheServer) {
  ASSERT_TRUE(Put(SmallMap()).ok());
  Reopen();
  // No file can be opened or made any more, whoever tries.
  std::filesystem::rename(folder_.path() / "maps", folder_.path() / "gone");
  std::ofstream(folder_.path() / "maps") << "no folder";
  for (const absl::Status& status :
       {store_->Acquire("town", 0).status(), Put(SmallMap("second")).status(),
        store_->HasStored("", Sha256Of(SmallMap())).status()}) {
    EXPECT_FALSE(status.ok());
    EXPECT_THAT(MessageOf(status), Not(HasSubstr(folder_.path().string())));
  }
}

/// Each byte when DCLOC_EVERY_BYTE is set, a sample otherwise.
TEST_F(MapStoreTest, EachChangedByteAndEachCutIsNoticed) {
  const std::vector<std::byte> bytes = SmallMap();
  ASSERT_TRUE(Put(bytes).ok());
  MapFiles& files = store_->files();
  const auto write = [&](std::span<const std::byte> changed) {
    std::ofstream(FileOf(bytes), std::ios::binary) << TextOf(changed);
    return files.Open(Sha256Of(bytes)).status().code();
  };
  const std::size_t step = std::getenv("DCLOC_EVERY_BYTE") == nullptr ? 97 : 1;
  for (std::size_t i = 0; i < bytes.size(); i += step) {
    std::vector<std::byte> changed = bytes;
    changed[i] ^= std::byte{1};
    ASSERT_EQ(write(changed), absl::StatusCode::kDataLoss) << "byte " << i;
    ASSERT_EQ(write(std::span(bytes).first(i)), absl::StatusCode::kDataLoss) << i << " bytes";
  }
  EXPECT_EQ(write(bytes), absl::StatusCode::kOk);
}

TEST_F(MapStoreTest, AnUploadOfTheSameBytesMendsTheFile) {
  const std::vector<std::byte> bytes = SmallMap();
  ASSERT_TRUE(Put(bytes).ok());
  for (const bool in_use : {false, true}) {
    Reopen();
    absl::StatusOr<LoadedMap> user =
        in_use ? store_->Acquire("town", 0) : absl::StatusOr<LoadedMap>(absl::CancelledError());
    EXPECT_EQ(user.ok(), in_use);
    std::fstream(FileOf(bytes), std::ios::in | std::ios::out | std::ios::binary).put('?');
    EXPECT_FALSE(*store_->HasStored("", Sha256Of(bytes))) << "the client is to send it";
    EXPECT_EQ(Upload::Begin(*store_, RequestFor(bytes), kLimits)->Finish().status().code(),
              absl::StatusCode::kDataLoss)
        << "a hash alone mends nothing";
    EXPECT_EQ(Put(bytes)->version, 1);
    EXPECT_TRUE(*store_->HasStored("", Sha256Of(bytes)));
    user = absl::CancelledError();
    Reopen();
    EXPECT_TRUE(store_->Acquire("town", 0).ok());
  }
}

TEST_F(MapStoreTest, UploadsUnderWayCountBeforeTheirBytesCome) {
  const UploadLimits limits{.max_map_bytes = kMaxMapBytes, .max_tenant_bytes = 1 << 20};
  std::vector<Upload> begun;
  const auto begin = [&](char digit) {
    UploadRequest request = RequestFor(SmallMap());
    request.sha256 = std::string(64, digit);
    request.size_bytes = 400'000;
    absl::StatusOr<Upload> upload = Upload::Begin(*store_, request, limits);
    const absl::Status status = upload.status();
    if (upload.ok()) begun.push_back(*std::move(upload));
    return status;
  };
  EXPECT_TRUE(begin('a').ok() && begin('b').ok());
  const absl::Status refused = begin('c');
  EXPECT_EQ(refused.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(MessageOf(refused), AllOf(HasSubstr("unfinished uploads 800000"),
                                        HasSubstr("max_tenant_storage_mib is 1")));
  EXPECT_TRUE(begin('b').ok()) << "a file counts once";
  begun.clear();
  EXPECT_TRUE(begin('c').ok()) << "their room was given back";
}

TEST_F(MapStoreTest, BytesOfAnUnfinishedUploadCountAfterARestart) {
  const std::vector<std::byte> bytes = SmallMap("long", 700);
  {
    absl::StatusOr<Upload> upload = Upload::Begin(*store_, RequestFor(bytes), kLimits);
    ASSERT_TRUE(AppendAll(*upload, bytes).ok());
  }
  Reopen();
  UploadRequest other = RequestFor(bytes);
  other.sha256 = std::string(64, 'a');
  const UploadLimits limits{.max_map_bytes = kMaxMapBytes, .max_tenant_bytes = 1 << 20};
  EXPECT_EQ(Upload::Begin(*store_, other, limits).status().code(),
            absl::StatusCode::kResourceExhausted);
  EXPECT_TRUE(Upload::Begin(*store_, RequestFor(bytes), limits).ok());
}

TEST_F(MapStoreTest, AKnownHashWithAnotherSizeIsRefused) {
  ASSERT_TRUE(Put(SmallMap()).ok());
  UploadRequest request = RequestFor(SmallMap());
  request.size_bytes += 1;
  EXPECT_EQ(Upload::Begin(*store_, request, kLimits).status().code(),
            absl::StatusCode::kInvalidArgument);
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

// ---- Beside other processes

TEST_F(MapStoreTest, WhoeverKeepsTheCatalogueLockedHoldsUpNoSession) {
  ASSERT_TRUE(Put(SmallMap()).ok());
  absl::StatusOr<SqliteDatabase> other = SqliteDatabase::Open(folder_.path() / "catalogue.sqlite");
  ASSERT_TRUE(other->Run("BEGIN IMMEDIATE").ok());
  absl::Status activated;
  std::thread activation([&] { activated = store_->Activate("town", 1).status(); });
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(store_->AcquireFor("town", "car-1").ok());
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(500));
  activation.join();
  EXPECT_EQ(activated.code(), absl::StatusCode::kUnavailable) << activated;
  ASSERT_TRUE(other->Run("ROLLBACK").ok());
  EXPECT_TRUE(store_->Activate("town", 1).ok());
}

TEST_F(MapStoreTest, AVersionThatAnotherProcessUsesIsNotDeleted) {
  ASSERT_TRUE(Put(SmallMap("first")).ok());
  ASSERT_TRUE(Put(SmallMap("second")).ok());
  absl::StatusOr<Hold> other = store_->catalogue().HoldVersion("town", 1, "other:1");
  ASSERT_TRUE(other.ok()) << other.status();
  EXPECT_EQ(store_->DeleteVersion("town", 1).code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(store_->DeleteMap("town").code(), absl::StatusCode::kFailedPrecondition);
  *other = Hold();
  EXPECT_TRUE(store_->DeleteVersion("town", 1).ok());
}

TEST_F(MapStoreTest, WhatIsUsedHereIsHeldInTheCatalogueAndWhatIsWarmIsNot) {
  ASSERT_TRUE(Put(SmallMap()).ok());
  absl::StatusOr<LoadedMap> in_use = store_->Acquire("town", 1);
  ASSERT_TRUE(in_use.ok()) << in_use.status();
  absl::StatusOr<LoadedMap> again = store_->Acquire("town", 1);
  EXPECT_EQ(store_->catalogue().DeleteMap("town").code(), absl::StatusCode::kFailedPrecondition);
  *in_use = {};
  EXPECT_EQ(store_->catalogue().DeleteMap("town").code(), absl::StatusCode::kFailedPrecondition)
      << "the second user keeps it";
  *again = {};
  EXPECT_EQ(store_->loaded_map_count(), 1) << "warm";
  EXPECT_TRUE(store_->catalogue().DeleteMap("town").ok());
}

TEST_F(MapStoreTest, AMapThatWasMadeAnewElsewhereIsNotServedFromWarmMemory) {
  const std::vector<std::byte> second = SmallMap("second");
  ASSERT_TRUE(Put(SmallMap("first")).ok());
  const MapVersionRecord city = *PutAs("city", second);
  ASSERT_EQ(store_->loaded_map_count(), 2) << "both are warm";
  Catalogue& catalogue = store_->catalogue();
  ASSERT_TRUE(catalogue.DeleteMap("town").ok());
  ASSERT_TRUE(catalogue.AddVersion("town", city.sha256, city.info, {}).ok());
  ASSERT_TRUE(catalogue.Activate("town", 1).ok());
  EXPECT_EQ(store_->Acquire("town", 0)->map->info().name, "second");
}

TEST_F(MapStoreTest, AFileThatAnotherProcessIsStoringStaysWhenItsLastVersionGoes) {
  const std::vector<std::byte> bytes = SmallMap();
  ASSERT_TRUE(Put(bytes).ok());
  absl::StatusOr<Hold> other = store_->catalogue().HoldFile(Sha256Of(bytes), "other:1");
  ASSERT_TRUE(other.ok()) << other.status();
  EXPECT_TRUE(store_->DeleteMap("town").ok());
  EXPECT_EQ(FileCount(), 1);
  EXPECT_EQ(Put(bytes).status().code(), absl::StatusCode::kUnavailable);
  *other = Hold();
  EXPECT_TRUE(Put(bytes).ok());
  EXPECT_TRUE(store_->DeleteMap("town").ok());
  EXPECT_EQ(FileCount(), 0);
}

}  // namespace
}  // namespace dcloc::server
