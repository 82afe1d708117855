#include "server/convert/position_fix.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/server/convert/convert_fault.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

v1::PositionFix SatelliteFix() {
  v1::PositionFix fix = FixMessage(1);
  *fix.mutable_gnss_fix() = GnssFixMessage();
  return fix;
}

using FixFault = Fault<v1::PositionFix>;
class FixFaultTest : public ::testing::TestWithParam<FixFault> {};

TEST_P(FixFaultTest, IsRefusedByName) { ExpectRefused(GetParam(), FixMessage(1)); }

INSTANTIATE_TEST_SUITE_P(
    Convert, FixFaultTest,
    ::testing::Values(
        FixFault{"NoStamp", [](auto* m) { m->clear_stamp_ns(); }, {"position_fix.stamp_ns", "0"}},
        FixFault{"StampInTheFarFuture",
                 [](auto* m) { m->set_stamp_ns(5'000'000'000'000'000'000); },
                 {"position_fix.stamp_ns", "5000000000000000000", "4102444800000000000"}},
        FixFault{"NoPosition",
                 [](auto* m) { m->clear_position(); },
                 {"position_fix.position", "missing"}},
        FixFault{"NoPose",
                 [](auto* m) { m->mutable_map_pose()->clear_pose(); },
                 {"position_fix.map_pose.pose", "missing"}},
        FixFault{"NanPose",
                 [](auto* m) {
                   m->mutable_map_pose()->mutable_pose()->mutable_translation_m()->set_y(kNan);
                 },
                 {"position_fix.map_pose.pose.translation_m.y", "nan"}},
        FixFault{"ShortCovariance",
                 [](auto* m) { m->mutable_map_pose()->mutable_covariance()->RemoveLast(); },
                 {"position_fix.map_pose.covariance", "35", "36"}},
        FixFault{"NegativeVariance",
                 [](auto* m) { m->mutable_map_pose()->set_covariance(7, -1.0); },
                 {"position_fix.map_pose.covariance", "semidefinite"}},
        FixFault{"OffTheEarth",
                 [](auto* m) {
                   *m = SatelliteFix();
                   m->mutable_gnss_fix()->mutable_position()->set_latitude_deg(91.0);
                 },
                 {"position_fix.gnss_fix.position", "91", "90"}},
        FixFault{"NoSigma",
                 [](auto* m) {
                   *m = SatelliteFix();
                   m->mutable_gnss_fix()->clear_horizontal_sigma_m();
                 },
                 {"position_fix.gnss_fix.horizontal_sigma_m", "0", "0.001"}},
        FixFault{"HeadingSigmaAlone",
                 [](auto* m) {
                   *m = SatelliteFix();
                   m->mutable_gnss_fix()->set_heading_sigma_deg(2.0);
                 },
                 {"position_fix.gnss_fix.heading_deg", "missing"}}),
    FaultName<v1::PositionFix>);

TEST(ConvertFixTest, AFixInTheMapIsTakenAsItIs) {
  const auto fix = convert::FromProto(FixMessage(3), std::nullopt);
  ASSERT_TRUE(fix.ok()) << fix.status();
  EXPECT_EQ(fix->stamp.time_since_epoch().count(), FixMessage(3).stamp_ns());
  EXPECT_EQ(fix->pose.T_map_vehicle.translation_m.norm(), 0.0);
  EXPECT_EQ(fix->pose.covariance(5, 5), 0.01);
}

TEST(ConvertFixTest, ASatelliteFixNeedsAnAnchorAndBecomesAPlaceInTheMap) {
  const auto fix = convert::FromProto(SatelliteFix(), kAnchor);
  ASSERT_TRUE(fix.ok()) << fix.status();
  const GeodeticPosition back = GeodeticFromMap(kAnchor, fix->pose.T_map_vehicle.translation_m);
  EXPECT_NEAR(back.latitude_deg, 52.001, 1e-9);
  const absl::Status status = convert::FromProto(SatelliteFix(), std::nullopt).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status.message()), HasSubstr("position_fix.gnss_fix"));
}

TEST(ConvertFixTest, AnAnswerSaysWhatBecameOfTheFix) {
  const auto use_of = [](absl::StatusOr<FixUse> use) {
    v1::PositionFixAnswer message;
    message.set_message("before");
    convert::ToProto(FixAnswer{.stamp_ns = 7, .use = std::move(use)}, &message);
    EXPECT_EQ(message.stamp_ns(), 7);
    return std::pair(message.use(), message.message());
  };
  const auto plain = [](v1::FixUse use) { return std::pair(use, std::string()); };
  EXPECT_EQ(use_of(FixUse::kFused), plain(v1::FIX_USE_FUSED));
  EXPECT_EQ(use_of(FixUse::kConsistentNotFused), plain(v1::FIX_USE_FUSED));
  EXPECT_EQ(use_of(FixUse::kGuidesSearch), plain(v1::FIX_USE_GUIDES_SEARCH));
  EXPECT_EQ(use_of(FixUse::kContradicted), plain(v1::FIX_USE_CONTRADICTED));
  EXPECT_EQ(use_of(FixUse::kOutOfTime), plain(v1::FIX_USE_OUT_OF_TIME));
  EXPECT_EQ(use_of(absl::InvalidArgumentError("x is 2")),
            std::pair(v1::FIX_USE_INVALID, std::string("x is 2")));
  EXPECT_EQ(use_of(absl::ResourceExhaustedError("3 a second")),
            std::pair(v1::FIX_USE_OVER_LIMIT, std::string("3 a second")));
}

}  // namespace
}  // namespace dcloc::server
