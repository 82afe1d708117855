#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/app/storage.h"
#include "server/maps/jobs/upload.h"
#include "server/maps/store/map_store.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/messages.h"
#include "tests/server/fixtures/test_maps.h"

namespace dcloc::server {

inline absl::string_view TextOf(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// A store in a folder of its own.
class StoreFixture : public ::testing::Test {
 protected:
  static constexpr UploadLimits kNoLimits{.max_map_bytes = std::int64_t{1} << 40};

  explicit StoreFixture(MapStoreOptions options = {}) : options_(options) { Reopen(); }

  void Reopen() {
    Close();
    absl::StatusOr<Storage> storage = OpenStorage(folder_.path(), options_);
    ASSERT_TRUE(storage.ok()) << storage.status();
    storage_.emplace(*std::move(storage));
    store_ = storage_->maps.get();
  }

  void Close() {
    store_ = nullptr;
    storage_.reset();
  }

  static UploadRequest RequestFor(std::span<const std::byte> bytes, bool activate = true) {
    return {.map_name = "town",
            .size_bytes = static_cast<std::int64_t>(bytes.size()),
            .sha256 = Sha256Of(bytes),
            .activate = activate};
  }

  /// Gives the version's number, or 0 and a failure.
  std::int64_t Put(std::span<const std::byte> bytes, bool activate = true) {
    absl::StatusOr<Upload> upload = Upload::Begin(*store_, RequestFor(bytes, activate), kNoLimits);
    EXPECT_TRUE(upload.ok()) << upload.status();
    const absl::Status status = AppendAll(*upload, bytes);
    EXPECT_TRUE(status.ok()) << status;
    const absl::StatusOr<MapVersionRecord> record = upload->Finish();
    EXPECT_TRUE(record.ok()) << record.status();
    return record.ok() ? record->version : 0;
  }

  /// From `begin` to `end` of the bytes.
  static absl::Status AppendAll(Upload& upload, std::span<const std::byte> bytes,
                                std::size_t begin = 0, std::size_t end = std::size_t(-1)) {
    constexpr std::size_t kPart = std::size_t{1} << 20;
    absl::Status status;
    end = std::min(end, bytes.size());
    while (status.ok() && begin < end) {
      const auto part = bytes.subspan(begin, std::min(kPart, end - begin));
      status = upload.Append(static_cast<std::int64_t>(begin), TextOf(part));
      begin += part.size();
    }
    return status;
  }

  MapRecord Town() { return *store_->catalogue().GetMap("town"); }

  /// Where the store keeps a map.
  std::filesystem::path FileOf(std::span<const std::byte> bytes) const {
    const std::string sha256 = Sha256Of(bytes);
    return folder_.path() / "maps" / sha256.substr(0, 2) / (sha256 + ".dcmap");
  }

  const MapStoreOptions options_;
  TemporaryFolder folder_;
  std::optional<Storage> storage_;
  MapStore* store_ = nullptr;
};

}  // namespace dcloc::server
