#include "server/sessions/canary_watch.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/app/storage.h"
#include "server/maps/jobs/upload.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/messages.h"
#include "tests/server/sessions/session_test_parts.h"

namespace dcloc::server {
namespace {

class QuietStream final : public SessionStream {
 public:
  void Announce(const v1::SessionEnding& /*ending*/) override {}
  void End(grpc::Status /*status*/) override {}
  void Displace(grpc::Status /*status*/) override {}
  void Abort() override {}
};

/// A store with a map of two versions, the second one its canary, and vehicles in both.
class CanaryWatchTest : public SessionParts {
 protected:
  CanaryWatchTest() {
    Put(SmallMap(), true);
    Put(SmallMap("other"), false);
    EXPECT_TRUE(store().SetCanary("town", 2, 0.2).ok());
  }

  MapStore& store() { return *storage_->maps; }

  void Put(const std::vector<std::byte>& bytes, bool activate) {
    absl::StatusOr<Upload> upload =
        Upload::Begin(store(),
                      {.map_name = "town",
                       .size_bytes = static_cast<std::int64_t>(bytes.size()),
                       .sha256 = Sha256Of(bytes),
                       .activate = activate},
                      {.max_map_bytes = std::int64_t{1} << 30});
    ASSERT_TRUE(upload.ok()) << upload.status();
    ASSERT_TRUE(
        upload->Append(0, {reinterpret_cast<const char*>(bytes.data()), bytes.size()}).ok());
    ASSERT_TRUE(upload->Finish().ok());
  }

  /// `count` vehicles in a version, each TRACKING or LOST all the time.
  void Drive(int count, std::int64_t version, LocalizationState state, bool asked_for = false) {
    for (int i = 0; i < count; ++i) {
      auto info = std::make_shared<SessionInfo>();
      info->description.session_id = absl::StrCat(version, "-", i, "-", next_++);
      info->description.vehicle_id = info->description.session_id;
      info->description.map_name = "town";
      info->description.map_version_asked_for = asked_for;
      info->map_version = version;
      info->last_state = static_cast<int>(state);
      ASSERT_TRUE(registry_.Add(info, session_, stream_).ok());
    }
  }

  void LookFor(int seconds) {
    for (int i = 0; i < seconds; ++i) watch_.Look();
    watch_.Judge();
  }

  std::int64_t Canary() { return store().catalogue().GetMap("town")->canary_version; }

  TemporaryFolder folder_;
  std::unique_ptr<Storage> storage_ =
      std::make_unique<Storage>(OpenStorage(folder_.path()).value());
  SessionRegistry registry_{limits_, {}};
  std::shared_ptr<Session> session_ = MakeSession();
  std::shared_ptr<QuietStream> stream_ = std::make_shared<QuietStream>();
  CanaryWatch watch_{registry_, store()};
  int next_ = 0;
};

TEST_F(CanaryWatchTest, OneInWhichVehiclesAreLostIsWithdrawn) {
  Drive(20, 1, LocalizationState::kTracking);
  Drive(6, 2, LocalizationState::kLost);
  LookFor(1);  // learns which versions there are
  LookFor(30);
  EXPECT_EQ(Canary(), 2) << "too short a time";
  LookFor(60);
  EXPECT_EQ(Canary(), 0);
  EXPECT_EQ(watch_.withdrawn_count(), 1);
  LookFor(60);
  EXPECT_EQ(watch_.withdrawn_count(), 1);
}

TEST_F(CanaryWatchTest, OneInWhichVehiclesTrackStays) {
  Drive(20, 1, LocalizationState::kTracking);
  Drive(6, 2, LocalizationState::kTracking);
  for (int i = 0; i < 10; ++i) LookFor(60);
  EXPECT_EQ(Canary(), 2);
}

TEST_F(CanaryWatchTest, VehiclesThatAskedForAVersionDoNotCount) {
  Drive(20, 1, LocalizationState::kTracking);
  Drive(6, 2, LocalizationState::kLost, /*asked_for=*/true);
  for (int i = 0; i < 3; ++i) LookFor(60);
  EXPECT_EQ(Canary(), 2);
}

TEST_F(CanaryWatchTest, WithAnotherCanaryAllBeginsAnew) {
  Drive(20, 1, LocalizationState::kTracking);
  Drive(6, 2, LocalizationState::kLost);
  LookFor(1);
  LookFor(50);
  Put(SmallMap("third"), false);
  ASSERT_TRUE(store().SetCanary("town", 3, 0.2).ok());
  LookFor(20);
  EXPECT_EQ(Canary(), 3) << "its vehicles were not looked at yet";
}

}  // namespace
}  // namespace dcloc::server
