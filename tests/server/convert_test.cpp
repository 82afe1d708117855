#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "core/geometry/covariance.h"
#include "server/convert/geometry.h"
#include "server/convert/page.h"
#include "server/convert/scan.h"
#include "server/convert/session.h"
#include "tests/server/messages.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr float kNanF = std::numeric_limits<float>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr float kInfinityF = std::numeric_limits<float>::infinity();

const GeodeticAnchor kAnchor{
    .origin = {.latitude_deg = 52.0, .longitude_deg = 8.0, .height_m = 100.0},
    .x_axis_east_rad = 0.3};

Rig FrontRig() {
  v1::Rig message;
  *message.add_radars() = RadarMessage("front");
  return *convert::FromProto(message, "rig");
}

absl::Status Convert(const v1::Scan& message) {
  Scan scan;
  return convert::FromProto(message, FrontRig(), &scan);
}

absl::Status Convert(const v1::OpenSession& message) {
  if (auto request = convert::FromProto(message); !request.ok()) return request.status();
  return convert::InitialPoseFromProto(message, kAnchor).status();
}

/// Something wrong, and what the error must name.
template <typename Message>
struct Fault {
  const char* name;
  std::function<void(Message*)> spoil;
  std::vector<std::string> named;
};

template <typename Message>
void ExpectRefused(const Fault<Message>& fault, Message message) {
  fault.spoil(&message);
  const absl::Status status = Convert(message);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << fault.name << ": " << status;
  for (const std::string& part : fault.named) {
    EXPECT_THAT(std::string(status.message()), HasSubstr(part)) << fault.name;
  }
}

template <typename Message>
std::string FaultName(const ::testing::TestParamInfo<Fault<Message>>& info) {
  return info.param.name;
}

// ---- Scans

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

// ---- Opening a session

v1::OpenSession OpenWithFix() {
  v1::OpenSession open = OpenMessage();
  v1::GnssFix* fix = open.mutable_gnss_fix();
  fix->mutable_position()->set_latitude_deg(52.001);
  fix->mutable_position()->set_longitude_deg(8.002);
  fix->mutable_position()->set_height_m(100.0);
  fix->set_horizontal_sigma_m(3.0);
  fix->set_vertical_sigma_m(5.0);
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
  EXPECT_FALSE(request->options.uncertainty);
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

// ---- Answers

TEST(ConvertAnswerTest, CovarianceTurnsToFixedAxesAndBack) {
  // A vehicle that heads along the map's y axis, sure ahead and unsure to its left.
  v1::PoseWithCovariance message = InitialPoseMessage();
  const double half = std::numbers::pi / 4.0;
  message.mutable_pose()->mutable_rotation()->set_w(std::cos(half));
  message.mutable_pose()->mutable_rotation()->set_z(std::sin(half));
  message.set_covariance(0, 9.0);
  message.set_covariance(7, 1.0);
  v1::OpenSession open = OpenMessage();
  *open.mutable_initial_pose() = message;
  const auto pose = convert::InitialPoseFromProto(open, std::nullopt);
  ASSERT_TRUE(pose.ok()) << pose.status();
  EXPECT_NEAR((*pose)->covariance(0, 0), 1.0, 1e-12) << "ahead is the map's y";
  EXPECT_NEAR((*pose)->covariance(1, 1), 9.0, 1e-12) << "left is the map's -x";
  v1::PoseWithCovariance back;
  convert::ToProto((*pose)->T_map_vehicle, (*pose)->covariance, &back);
  ASSERT_EQ(back.covariance_size(), 36);
  for (int i = 0; i < 36; ++i) EXPECT_NEAR(back.covariance(i), message.covariance(i), 1e-12) << i;
}

TEST(ConvertAnswerTest, CovarianceIsRowMajorOnTheWire) {
  Matrix6d covariance = Matrix6d::Identity();
  covariance(0, 5) = covariance(5, 0) = 0.25;
  v1::PoseWithCovariance message;
  convert::ToProto(Pose3(), covariance, &message);
  EXPECT_EQ(message.covariance(5), 0.25);
  EXPECT_EQ(message.covariance(30), 0.25);
  EXPECT_EQ(message.covariance(1), 0.0);
}

TEST(ConvertAnswerTest, HeadingFollowsTheMapsAxes) {
  const GeodeticAnchor east{.origin = kAnchor.origin, .x_axis_east_rad = 0.0};
  v1::GeodeticPose message;
  convert::ToProto(east, Pose3(), &message);
  EXPECT_NEAR(message.heading_deg(), 90.0, 1e-6);
  Pose3 south;
  south.rotation = Eigen::AngleAxisd(-std::numbers::pi / 2.0, Eigen::Vector3d::UnitZ());
  convert::ToProto(east, south, &message);
  EXPECT_NEAR(message.heading_deg(), 180.0, 1e-6);
  const GeodeticAnchor north{.origin = kAnchor.origin, .x_axis_east_rad = std::numbers::pi / 2.0};
  convert::ToProto(north, Pose3(), &message);
  EXPECT_NEAR(std::remainder(message.heading_deg(), 360.0), 0.0, 1e-6);
  EXPECT_GE(message.heading_deg(), 0.0);
  EXPECT_LT(message.heading_deg(), 360.0);
}

TEST(ConvertAnswerTest, CarriesStateQualityAndObservedDegreesOfFreedom) {
  Localization localization;
  localization.stamp = Stamp(std::chrono::nanoseconds(42));
  localization.state = LocalizationState::kLost;
  localization.observed[0] = localization.observed[1] = localization.observed[5] = true;
  localization.quality.inlier_count = 17;
  localization.quality.edge_valid = true;
  v1::LocalizationResult message;
  convert::ToProto(localization, &message);
  EXPECT_EQ(message.stamp_ns(), 42);
  EXPECT_EQ(message.state(), v1::LOCALIZATION_STATE_LOST);
  EXPECT_EQ(message.observed_dof_mask(), 0b100011);
  EXPECT_EQ(message.quality().inlier_count(), 17);
  EXPECT_TRUE(message.quality().edge_valid());
}

// ---- Pages

TEST(ConvertPageTest, SizesAndTokens) {
  EXPECT_EQ(*convert::PageSizeFromProto(0), 100);
  EXPECT_EQ(*convert::PageSizeFromProto(7), 7);
  EXPECT_EQ(convert::PageSizeFromProto(-1).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(convert::PageSizeFromProto(1001).status().message()),
              HasSubstr("page_size is 1001"));
  EXPECT_EQ(*convert::NumberFromPageToken("", 9), 9);
  EXPECT_EQ(*convert::NumberFromPageToken("12", 9), 12);
  EXPECT_FALSE(convert::NumberFromPageToken("x", 9).ok());
  EXPECT_FALSE(convert::NumberFromPageToken("-3", 9).ok());
  EXPECT_FALSE(convert::CheckPageToken("a b").ok());
}

}  // namespace
}  // namespace dcloc::server
