#pragma once

#include <memory>
#include <string>

#include "server/passes/pass_store.h"
#include "server/passes/sqlite_pass_rows.h"
#include "tests/core/map/temporary_folder.h"

namespace dcloc::server {

/// A store of passes in which map "town" and identity "car-1" consent.
struct TestPasses {
  explicit TestPasses(const std::string& key = std::string(32, 'k')) {
    store = std::make_unique<PassStore>(*SqlitePassRows::Open(folder.path() / "passes.sqlite"),
                                        *KeptFolder::Open(folder.path() / "passes"), key);
    store->GiveConsent("", {.subject = ConsentSubject::kMap, .name = "town"}).IgnoreError();
    store->GiveConsent("", {.subject = ConsentSubject::kIdentity, .name = "car-1"}).IgnoreError();
  }

  std::vector<PassRow> List() const { return *store->rows().List("", "town", 1 << 30, 100); }

  std::size_t FileCount() const {
    std::size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path() / "passes")) {
      count += entry.is_regular_file() ? 1U : 0U;
    }
    return count;
  }

  TemporaryFolder folder;
  std::unique_ptr<PassStore> store;
};

inline constexpr PassBounds kWideBounds{
    .quota = {.max_tenant_bytes = 1 << 30, .max_vehicle_bytes_per_day = 1 << 30},
    .retention = std::chrono::hours(24)};

inline NewPass TownPass() {
  return {.tenant = "",
          .map_name = "town",
          .map_version = 1,
          .identity_name = "car-1",
          .vehicle_id = "car-1"};
}

}  // namespace dcloc::server
