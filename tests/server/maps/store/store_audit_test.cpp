#include "server/maps/store/store_audit.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/server/maps/store/map_store_fixture.h"

namespace dcloc::server {
namespace {

class StoreAuditTest : public StoreFixture {
 protected:
  StoreAuditTest() {
    Put(first_);
    Put(second_);
  }

  StoreAudit Audit() {
    const absl::StatusOr<StoreAudit> audit =
        AuditStore(store_->catalogue(), store_->files(), [&](const StoreProgress& progress) {
          progress_ = progress;
          return true;
        });
    EXPECT_TRUE(audit.ok()) << audit.status();
    return *audit;
  }

  const std::vector<std::byte> first_ = SmallMap("first");
  const std::vector<std::byte> second_ = SmallMap("second");
  StoreProgress progress_;
};

TEST_F(StoreAuditTest, AWholeStoreIsReadInFull) {
  const StoreAudit audit = Audit();
  EXPECT_TRUE(audit.ok());
  EXPECT_EQ(audit.file_count, 2);
  EXPECT_EQ(audit.size_bytes, static_cast<std::int64_t>(first_.size() + second_.size()));
  EXPECT_EQ(progress_.done_bytes, audit.size_bytes);
}

TEST_F(StoreAuditTest, SaysWhatIsMissingDamagedAndUnaccountedFor) {
  const std::string unknown(64, 'd');
  std::filesystem::remove(FileOf(first_));
  std::fstream(FileOf(second_), std::ios::in | std::ios::out | std::ios::binary).put('?');
  std::ofstream(folder_.path() / "maps" / (unknown + ".dcmap")) << "a map";
  const StoreAudit audit = Audit();
  EXPECT_FALSE(audit.ok());
  EXPECT_EQ(audit.missing_files, std::vector<std::string>{Sha256Of(first_)});
  EXPECT_EQ(audit.damaged_files, std::vector<std::string>{Sha256Of(second_)});
  EXPECT_EQ(audit.unaccounted_files, std::vector<std::string>{unknown});
}

TEST_F(StoreAuditTest, CanBeStopped) {
  EXPECT_TRUE(
      absl::IsCancelled(AuditStore(store_->catalogue(), store_->files(), [](const StoreProgress&) {
                          return false;
                        }).status()));
}

}  // namespace
}  // namespace dcloc::server
