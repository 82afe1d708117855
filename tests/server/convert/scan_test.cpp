#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <string>

#include "tests/server/convert/convert_fault.h"

namespace dcloc::server {
namespace {

void AddTick(std::int64_t stamp_offset_ns, float speed_mps, v1::Scan* message) {
  v1::MotionTicks& motion = *message->mutable_motion();
  motion.add_stamp_offset_ns(stamp_offset_ns);
  motion.add_speed_mps(speed_mps);
  motion.add_yaw_rate_radps(0.1F);
}

class ScanFaultTest : public ::testing::TestWithParam<Fault<v1::Scan>> {};

TEST_P(ScanFaultTest, IsRefusedByName) { ExpectRefused(GetParam(), ScanMessage(1)); }

INSTANTIATE_TEST_SUITE_P(
    Convert, ScanFaultTest,
    ::testing::Values(
        Fault<v1::Scan>{"NegativeSequenceNumber", [](auto* m) { m->set_sequence_number(-4); },
                        {"sequence_number", "-4", "0"}},
        Fault<v1::Scan>{"StampMissing", [](auto* m) { m->clear_stamp_ns(); },
                        {"stamp_ns", "0", "[1,"}},
        Fault<v1::Scan>{"StampNegative", [](auto* m) { m->set_stamp_ns(-5); }, {"stamp_ns", "-5"}},
        Fault<v1::Scan>{"UnknownRadar", [](auto* m) { m->set_radar_id("rear\n"); },
                        {"radar_id", "\"rear\\n\"", "rig"}},
        Fault<v1::Scan>{"VeryLongRadar",
                        [](auto* m) { m->set_radar_id(std::string(100'000, 'x')); },
                        {"radar_id", "xxx...\""}},
        Fault<v1::Scan>{"ShortColumn", [](auto* m) { m->mutable_range_rate_mps()->RemoveLast(); },
                        {"range_rate_mps", "19", "20"}},
        Fault<v1::Scan>{"MissingColumn", [](auto* m) { m->clear_azimuth_rad(); },
                        {"azimuth_rad", "0", "20"}},
        Fault<v1::Scan>{"MissingRange", [](auto* m) { m->clear_range_m(); }, {"range"}},
        Fault<v1::Scan>{"LongOptionalColumn", [](auto* m) { m->add_rcs_dbsm(1.0F); },
                        {"rcs_dbsm", "21", "20"}},
        Fault<v1::Scan>{"ShortSigmas", [](auto* m) { m->add_range_sigma_m(0.1F); },
                        {"range_sigma_m", "1", "20"}},
        Fault<v1::Scan>{"NanRange", [](auto* m) { m->set_range_m(3, kNanF); },
                        {"range_m[3]", "nan"}},
        Fault<v1::Scan>{"InfiniteRange", [](auto* m) { m->set_range_m(0, kInfinityF); },
                        {"range_m[0]", "inf"}},
        Fault<v1::Scan>{"NegativeRange", [](auto* m) { m->set_range_m(7, -1.5F); },
                        {"range_m[7]", "-1.5"}},
        Fault<v1::Scan>{"FarRange", [](auto* m) { m->set_range_m(7, 5000.0F); },
                        {"range_m[7]", "5000", "1000"}},
        Fault<v1::Scan>{"NanRangeRate", [](auto* m) { m->set_range_rate_mps(2, kNanF); },
                        {"range_rate_mps[2]", "nan"}},
        Fault<v1::Scan>{"AbsurdRangeRate", [](auto* m) { m->set_range_rate_mps(2, 900.0F); },
                        {"range_rate_mps[2]", "900", "200"}},
        Fault<v1::Scan>{"AzimuthInDegrees", [](auto* m) { m->set_azimuth_rad(1, 45.0F); },
                        {"azimuth_rad[1]", "45", "3.14"}},
        Fault<v1::Scan>{"ElevationOutside",
                        [](auto* m) {
                          for (int i = 0; i < 20; ++i) m->add_elevation_rad(2.0F);
                        },
                        {"elevation_rad[0]", "2", "1.57"}},
        Fault<v1::Scan>{"ZeroSigma",
                        [](auto* m) {
                          for (int i = 0; i < 20; ++i) m->add_azimuth_sigma_rad(0.0F);
                        },
                        {"azimuth_sigma_rad[0]", "0"}},
        Fault<v1::Scan>{"TooManyTargets", [](auto* m) { *m = ScanMessage(1, 20'001); },
                        {"20001", "20000"}},
        Fault<v1::Scan>{"TicksWithoutSpeeds",
                        [](auto* m) {
                          m->mutable_motion()->add_stamp_offset_ns(-10'000'000);
                          m->mutable_motion()->add_yaw_rate_radps(0.1F);
                        },
                        {"motion", "1 stamps", "0 speeds", "1 yaw rates"}},
        Fault<v1::Scan>{"TickFarFromItsScan",
                        [](auto* m) { AddTick(std::numeric_limits<std::int64_t>::min(), 5.0F, m); },
                        {"motion.stamp_offset_ns[0]", "2e+09"}},
        Fault<v1::Scan>{"TickOfAbsurdSpeed", [](auto* m) { AddTick(-10'000'000, 900.0F, m); },
                        {"motion.speed_mps[0]", "900", "150"}},
        Fault<v1::Scan>{"TickThatIsNoNumber", [](auto* m) { AddTick(-10'000'000, kNanF, m); },
                        {"motion.speed_mps[0]", "nan"}},
        Fault<v1::Scan>{"TicksOutOfOrder",
                        [](auto* m) {
                          AddTick(-10'000'000, 5.0F, m);
                          AddTick(-10'000'000, 5.0F, m);
                        },
                        {"motion.stamp_offset_ns[1]", "not later"}},
        Fault<v1::Scan>{"TooManyTicks",
                        [](auto* m) {
                          for (int i = 0; i < 1001; ++i) AddTick(-i, 5.0F, m);
                        },
                        {"motion", "1001", "1000"}},
        Fault<v1::Scan>{
            "AbsurdVelocity",
            [](auto* m) { m->mutable_ego_velocity()->mutable_linear_mps()->set_x(1e9); },
            {"ego_velocity.linear_mps", "1e+09", "150"}},
        Fault<v1::Scan>{
            "NanVelocity",
            [](auto* m) { m->mutable_ego_velocity()->mutable_linear_mps()->set_y(kNan); },
            {"ego_velocity.linear_mps", "nan"}},
        Fault<v1::Scan>{
            "AbsurdTurnRate",
            [](auto* m) { m->mutable_ego_velocity()->mutable_angular_radps()->set_z(-60.0); },
            {"ego_velocity.angular_radps", "-60", "10"}},
        Fault<v1::Scan>{"VelocityCovarianceLength",
                        [](auto* m) { m->mutable_ego_velocity()->add_covariance(1.0); },
                        {"ego_velocity.covariance", "1 values", "36"}},
        Fault<v1::Scan>{
            "VelocityCovarianceNegative",
            [](auto* m) {
              *m->mutable_ego_velocity()->mutable_covariance() = InitialPoseMessage().covariance();
              m->mutable_ego_velocity()->set_covariance(0, -1.0);
            },
            {"ego_velocity.covariance", "positive semidefinite"}}),
    FaultName<v1::Scan>);

TEST(ConvertScanTest, TakesAllThatAScanHas) {
  v1::Scan message = ScanMessage(4, 3);
  SetColumn({0.1F, 0.2F, 0.3F}, message.mutable_elevation_rad());
  SetColumn({0.4F, 0.5F, 0.6F}, message.mutable_range_sigma_m());
  *message.mutable_ego_velocity()->mutable_covariance() = InitialPoseMessage().covariance();
  Scan scan;
  ASSERT_TRUE(convert::FromProto(message, FrontRig(), &scan).ok());
  EXPECT_EQ(scan.radar_id, "front");
  EXPECT_EQ(scan.stamp.time_since_epoch().count(), message.stamp_ns());
  EXPECT_THAT(scan.range_m, ::testing::ElementsAre(5.0F, 6.0F, 7.0F));
  EXPECT_THAT(scan.elevation_rad, ::testing::ElementsAre(0.1F, 0.2F, 0.3F));
  EXPECT_THAT(scan.range_sigma_m, ::testing::ElementsAre(0.4F, 0.5F, 0.6F));
  EXPECT_TRUE(scan.azimuth_sigma_rad.empty());
  ASSERT_TRUE(scan.ego_velocity.has_value());
  EXPECT_EQ(scan.ego_velocity->linear_mps, Eigen::Vector3d(10.0, 0.0, 0.0));
  ASSERT_TRUE(scan.ego_velocity->covariance.has_value());
  EXPECT_EQ((*scan.ego_velocity->covariance)(5, 5), 0.01);
}

TEST(ConvertScanTest, NothingOfTheScanBeforeShowsThrough) {
  v1::Scan full = ScanMessage(1);
  Scan scan;
  ASSERT_TRUE(convert::FromProto(full, FrontRig(), &scan).ok());
  v1::Scan empty = ScanMessage(2, 0);
  empty.clear_ego_velocity();
  ASSERT_TRUE(convert::FromProto(empty, FrontRig(), &scan).ok()) << "an empty scan is valid";
  EXPECT_EQ(scan.size(), 0U);
  EXPECT_TRUE(scan.rcs_dbsm.empty());
  EXPECT_FALSE(scan.ego_velocity.has_value());
}

}  // namespace
}  // namespace dcloc::server
