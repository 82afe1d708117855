#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <string>

#include "server/convert/geometry.h"
#include "tests/server/convert/convert_fault.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

v1::OpenSession OpenWithFix() {
  v1::OpenSession open = OpenMessage();
  *open.mutable_gnss_fix() = GnssFixMessage();
  return open;
}

class OpenFaultTest : public ::testing::TestWithParam<Fault<v1::OpenSession>> {};

TEST_P(OpenFaultTest, IsRefusedByName) { ExpectRefused(GetParam(), OpenMessage()); }

v1::RadarModel* FirstRadar(v1::OpenSession* open) { return open->mutable_rig()->mutable_radars(0); }
v1::PoseWithCovariance* Initial(v1::OpenSession* open) { return open->mutable_initial_pose(); }

using OpenFault = Fault<v1::OpenSession>;

INSTANTIATE_TEST_SUITE_P(
    Convert, OpenFaultTest,
    ::testing::Values(
        OpenFault{"NoVehicle", [](auto* m) { m->clear_vehicle_id(); }, {"open.vehicle_id", "64"}},
        OpenFault{"VehicleWithNewline", [](auto* m) { m->set_vehicle_id("a\nb"); },
                  {"open.vehicle_id", "a\\nb"}},
        OpenFault{"LongVehicle", [](auto* m) { m->set_vehicle_id(std::string(65, 'v')); },
                  {"open.vehicle_id", "64"}},
        OpenFault{"NoMapName", [](auto* m) { m->clear_map_name(); }, {"open.map_name", "63"}},
        OpenFault{"MapNameIsAPath", [](auto* m) { m->set_map_name("../town"); },
                  {"open.map_name", "../town"}},
        OpenFault{"NegativeVersion", [](auto* m) { m->set_map_version(-1); },
                  {"open.map_version", "-1", "0"}},
        OpenFault{"NoRig", [](auto* m) { m->clear_rig(); }, {"open.rig", "0 radars", "1"}},
        OpenFault{"TwoRadarsOfOneName",
                  [](auto* m) { *m->mutable_rig()->add_radars() = RadarMessage("front"); },
                  {"open.rig", "front", "unique"}},
        OpenFault{"RadarWithoutId", [](auto* m) { FirstRadar(m)->clear_radar_id(); },
                  {"open.rig.radars[0].radar_id"}},
        OpenFault{"RadarWithoutMount", [](auto* m) { FirstRadar(m)->clear_t_vehicle_radar(); },
                  {"open.rig.radars[0].t_vehicle_radar", "missing"}},
        OpenFault{
            "MountWithoutRotation",
            [](auto* m) { FirstRadar(m)->mutable_t_vehicle_radar()->clear_rotation(); },
            {"open.rig.radars[0].t_vehicle_radar.rotation", "missing"}},
        OpenFault{"MountFarAway",
                  [](auto* m) {
                    FirstRadar(m)->mutable_t_vehicle_radar()->mutable_translation_m()->set_x(500.0);
                  },
                  {"open.rig", "front", "500", "100"}},
        OpenFault{"NanBeta", [](auto* m) { FirstRadar(m)->set_beta_s(kNan); },
                  {"open.rig", "beta_s", "nan"}},
        OpenFault{"ChirpWithoutSlope",
                  [](auto* m) { FirstRadar(m)->mutable_chirp()->set_centre_frequency_hz(77e9); },
                  {"open.rig.radars[0].chirp.slope_hz_per_s", "0"}},
        OpenFault{"ChirpInGigahertz",
                  [](auto* m) {
                    FirstRadar(m)->mutable_chirp()->set_centre_frequency_hz(0.077);
                    FirstRadar(m)->mutable_chirp()->set_slope_hz_per_s(1e12);
                  },
                  {"open.rig.radars[0].chirp.centre_frequency_hz", "0.077"}},
        OpenFault{"ZeroSigma", [](auto* m) { FirstRadar(m)->set_range_sigma_m(0.0); },
                  {"open.rig", "range_sigma_m", "0"}},
        OpenFault{"PoseMissing", [](auto* m) { Initial(m)->clear_pose(); },
                  {"open.initial_pose.pose", "missing"}},
        OpenFault{"TranslationMissing",
                  [](auto* m) { Initial(m)->mutable_pose()->clear_translation_m(); },
                  {"open.initial_pose.pose.translation_m", "missing"}},
        OpenFault{
            "NanTranslation",
            [](auto* m) { Initial(m)->mutable_pose()->mutable_translation_m()->set_y(kNan); },
            {"open.initial_pose.pose.translation_m.y", "nan"}},
        OpenFault{
            "InfiniteTranslation",
            [](auto* m) { Initial(m)->mutable_pose()->mutable_translation_m()->set_z(kInfinity); },
            {"open.initial_pose.pose.translation_m.z", "inf"}},
        OpenFault{"NonUnitQuaternion",
                  [](auto* m) { Initial(m)->mutable_pose()->mutable_rotation()->set_w(2.0); },
                  {"norm", "open.initial_pose.pose.rotation", "2"}},
        OpenFault{"ZeroQuaternion",
                  [](auto* m) { Initial(m)->mutable_pose()->mutable_rotation()->set_w(0.0); },
                  {"norm", "open.initial_pose.pose.rotation", "is 0"}},
        OpenFault{"NanQuaternion",
                  [](auto* m) { Initial(m)->mutable_pose()->mutable_rotation()->set_x(kNan); },
                  {"norm", "open.initial_pose.pose.rotation", "nan"}},
        OpenFault{"NoCovariance", [](auto* m) { Initial(m)->clear_covariance(); },
                  {"open.initial_pose.covariance", "0 values", "36"}},
        OpenFault{"NanCovariance", [](auto* m) { Initial(m)->set_covariance(35, kNan); },
                  {"open.initial_pose.covariance[35]", "nan"}},
        OpenFault{"NegativeVariance", [](auto* m) { Initial(m)->set_covariance(7, -0.5); },
                  {"open.initial_pose.covariance", "positive semidefinite"}},
        OpenFault{"AsymmetricCovariance", [](auto* m) { Initial(m)->set_covariance(1, 0.5); },
                  {"open.initial_pose.covariance", "symmetric"}},
        OpenFault{"ImpossibleCorrelation",
                  [](auto* m) {
                    Initial(m)->set_covariance(1, 5.0);
                    Initial(m)->set_covariance(6, 5.0);
                  },
                  {"open.initial_pose.covariance", "positive semidefinite"}},
        OpenFault{"HugeVariance", [](auto* m) { Initial(m)->set_covariance(0, 1e300); },
                  {"open.initial_pose.covariance[0]", "1e+300"}},
        OpenFault{"NoScansPerSubmap",
                  [](auto* m) { m->mutable_options()->set_scans_per_submap(0); },
                  {"open.options", "scans_per_submap", "0", "[1, 100]"}},
        OpenFault{"FixWithoutPosition",
                  [](auto* m) {
                    *m = OpenWithFix();
                    m->mutable_gnss_fix()->clear_position();
                  },
                  {"open.gnss_fix.position", "missing"}},
        OpenFault{"FixOffTheEarth",
                  [](auto* m) {
                    *m = OpenWithFix();
                    m->mutable_gnss_fix()->mutable_position()->set_latitude_deg(91.0);
                  },
                  {"open.gnss_fix.position", "latitude_deg", "91", "90"}},
        OpenFault{"FixWithoutSigma",
                  [](auto* m) {
                    *m = OpenWithFix();
                    m->mutable_gnss_fix()->clear_horizontal_sigma_m();
                  },
                  {"open.gnss_fix.horizontal_sigma_m", "0"}},
        OpenFault{"HeadingSigmaWithoutHeading",
                  [](auto* m) {
                    *m = OpenWithFix();
                    m->mutable_gnss_fix()->set_heading_sigma_deg(2.0);
                  },
                  {"open.gnss_fix.heading_deg", "missing"}},
        OpenFault{"HeadingOutside",
                  [](auto* m) {
                    *m = OpenWithFix();
                    m->mutable_gnss_fix()->set_heading_deg(-10.0);
                    m->mutable_gnss_fix()->set_heading_sigma_deg(2.0);
                  },
                  {"open.gnss_fix.heading_deg", "-10", "360"}}),
    FaultName<v1::OpenSession>);

TEST(ConvertOpenTest, AbsentFieldsTakeTheDefaultsOfCore) {
  const absl::StatusOr<convert::SessionRequest> request = convert::FromProto(OpenMessage());
  ASSERT_TRUE(request.ok()) << request.status();
  EXPECT_EQ(request->options.scans_per_submap, LocalizerOptions().scans_per_submap);
  EXPECT_TRUE(request->options.doppler_compensation);
  EXPECT_EQ(request->rig.radars[0].range_sigma_m, RadarModel().range_sigma_m);
  EXPECT_EQ(request->rig.radars[0].beta_s, 0.0);
  EXPECT_EQ(request->map_version, 0);
}

TEST(ConvertOpenTest, TakesWhatIsGiven) {
  v1::OpenSession open = OpenMessage();
  open.mutable_options()->set_scans_per_submap(5);
  open.mutable_options()->set_uncertainty(false);
  FirstRadar(&open)->mutable_chirp()->set_centre_frequency_hz(77e9);
  FirstRadar(&open)->mutable_chirp()->set_slope_hz_per_s(-2e12);
  FirstRadar(&open)->set_azimuth_sigma_rad(0.03);
  const absl::StatusOr<convert::SessionRequest> request = convert::FromProto(open);
  ASSERT_TRUE(request.ok()) << request.status();
  EXPECT_EQ(request->options.scans_per_submap, 5);
  EXPECT_FALSE(request->options.per_point_covariance);
  EXPECT_DOUBLE_EQ(request->rig.radars[0].beta_s, 77e9 / -2e12);
  EXPECT_EQ(request->rig.radars[0].azimuth_sigma_rad, 0.03);
}

TEST(ConvertOpenTest, NoInitialPoseMeansNone) {
  v1::OpenSession open = OpenMessage();
  open.clear_initial_pose();
  const auto pose = convert::InitialPoseFromProto(open, kAnchor);
  ASSERT_TRUE(pose.ok());
  EXPECT_FALSE(pose->has_value());
}

TEST(ConvertOpenTest, AFixNeedsAnAnchor) {
  const auto pose = convert::InitialPoseFromProto(OpenWithFix(), std::nullopt);
  EXPECT_EQ(pose.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(pose.status().message()), HasSubstr("open.gnss_fix"));
}

TEST(ConvertOpenTest, AFixBecomesAPoseInTheMap) {
  v1::OpenSession open = OpenWithFix();
  open.mutable_gnss_fix()->set_heading_deg(30.0);
  open.mutable_gnss_fix()->set_heading_sigma_deg(4.0);
  const auto pose = convert::InitialPoseFromProto(open, kAnchor);
  ASSERT_TRUE(pose.ok()) << pose.status();
  const GeodeticPosition back = GeodeticFromMap(kAnchor, (*pose)->T_map_vehicle.translation_m);
  EXPECT_NEAR(back.latitude_deg, 52.001, 1e-9);
  EXPECT_NEAR(back.longitude_deg, 8.002, 1e-9);
  v1::GeodeticPose geodetic;
  convert::ToProto(kAnchor, (*pose)->T_map_vehicle, &geodetic);
  EXPECT_NEAR(geodetic.heading_deg(), 30.0, 1e-6);
  EXPECT_NEAR((*pose)->covariance(0, 0), 9.0, 1e-12);
  EXPECT_NEAR((*pose)->covariance(2, 2), 25.0, 1e-12);
  EXPECT_NEAR((*pose)->covariance(5, 5), std::pow(4.0 * std::numbers::pi / 180.0, 2), 1e-12);
}

TEST(ConvertOpenTest, AFixWithoutHeadingLeavesItOpen) {
  const auto pose = convert::InitialPoseFromProto(OpenWithFix(), kAnchor);
  ASSERT_TRUE(pose.ok()) << pose.status();
  EXPECT_GT(std::sqrt((*pose)->covariance(5, 5)), 1.5);
}

}  // namespace
}  // namespace dcloc::server
