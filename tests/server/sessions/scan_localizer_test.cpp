#include "server/sessions/scan_localizer.h"

#include <gtest/gtest.h>

#include <memory>

#include "server/convert/scan.h"
#include "server/convert/session.h"
#include "tests/server/fixtures/messages.h"
#include "tests/server/fixtures/test_maps.h"

namespace dcloc::server {
namespace {

Rig OneRadar() { return convert::FromProto(OpenMessage())->rig; }

Scan ScanOf(std::int64_t sequence_number) {
  Scan scan;
  EXPECT_TRUE(convert::FromProto(ScanMessage(sequence_number), OneRadar(), &scan).ok());
  return scan;
}

const InitialPose kAtOrigin{.T_map_vehicle = {}, .covariance = Matrix6d::Identity()};

TEST(CoreScanLocalizerTest, SessionsLendOneAnotherTheWorkspace) {
  WorkspacePool workspaces;
  const std::shared_ptr<const RadarMap> map = *RadarMap::FromBytes(SmallMap());
  for (int session = 0; session < 3; ++session) {
    auto localizer = CreateCoreScanLocalizer(workspaces, map, OneRadar(), kAtOrigin, {});
    ASSERT_TRUE(localizer.ok()) << localizer.status();
    for (int i = 0; i < 2; ++i) {
      const auto localization = (*localizer)->Localize(ScanOf(i), nullptr);
      ASSERT_TRUE(localization.ok()) << localization.status();
    }
  }
  EXPECT_EQ(workspaces.idle_count(), 1U);
}

TEST(CoreScanLocalizerTest, AnErrorGivesTheWorkspaceBack) {
  WorkspacePool workspaces;
  auto localizer = CreateCoreScanLocalizer(workspaces, *RadarMap::FromBytes(SmallMap()), OneRadar(),
                                           kAtOrigin, {});
  ASSERT_TRUE(localizer.ok()) << localizer.status();
  ASSERT_TRUE((*localizer)->Localize(ScanOf(5), nullptr).ok());
  EXPECT_FALSE((*localizer)->Localize(ScanOf(1), nullptr).ok()) << "it is earlier";
  EXPECT_EQ(workspaces.idle_count(), 1U);
}

TEST(StubScanLocalizerTest, GoesOnByTheVelocityThatIsSentAndSaysSo) {
  auto localizer =
      CreateStubScanLocalizer(*RadarMap::FromBytes(SmallMap()), OneRadar(), kAtOrigin, {});
  ASSERT_TRUE(localizer.ok());
  ASSERT_TRUE((*localizer)->Localize(ScanOf(1), nullptr).ok());
  const auto second = (*localizer)->Localize(ScanOf(2), nullptr);
  ASSERT_TRUE(second.ok());
  EXPECT_NEAR(second->T_map_vehicle.translation_m.x(), 0.77, 1e-9);
  EXPECT_EQ(second->state, LocalizationState::kDeadReckoning);
  EXPECT_TRUE(second->observed.none());
  EXPECT_EQ(second->quality.live_point_count, 0);
  EXPECT_EQ(second->health.radars.size(), 1U);
  EXPECT_FALSE(second->health.radars[0].is_used);
  EXPECT_EQ((*localizer)->TakeFix({.stamp = second->stamp, .pose = kAtOrigin}).value(),
            FixUse::kContradicted);
  EXPECT_TRUE((*localizer)->has_pose());
  EXPECT_FALSE((*localizer)->Localize(ScanOf(1), nullptr).ok()) << "it is earlier";
}

}  // namespace
}  // namespace dcloc::server
