#include "client/cli/remote/wire.h"

#include <gmock/gmock.h>
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "client/cli/session/wire_session.h"
#include "server/convert/answer.h"
#include "server/convert/position_fix.h"
#include "server/convert/scan.h"
#include "server/convert/session.h"

// What the client writes the server reads back as it was, and the other way round.
namespace dcloc::cli {
namespace {

Rig TwoRadars() {
  return {.radars = {{.id = "front",
                      .T_vehicle_radar = Exp(Vector6d(0.3 * Vector6d::Ones())),
                      .beta_s = -0.02,
                      .range_bias_m = 0.07,
                      .time_offset_s = -0.03,
                      .beta_sigma_s = 0.001,
                      .range_bias_sigma_m = 0.02,
                      .time_offset_sigma_s = 0.004,
                      .mount_yaw_sigma_rad = 0.003,
                      .range_sigma_m = 0.11,
                      .range_rate_sigma_mps = 0.12,
                      .azimuth_sigma_rad = 0.013,
                      .elevation_sigma_rad = 0.014,
                      .has_elevation = true,
                      .unambiguous_range_rate_mps = 25.0},
                     {.id = "rear"}}};
}

TEST(WireTest, ARigArrivesAsItWas) {
  const Rig rig = TwoRadars();
  const auto arrived = server::convert::FromProto(ToProto(rig), "rig");
  ASSERT_TRUE(arrived.ok()) << arrived.status();
  ASSERT_EQ(arrived->radars.size(), 2U);
  const RadarModel& sent = rig.radars[0];
  const RadarModel& radar = arrived->radars[0];
  EXPECT_EQ(radar.id, sent.id);
  EXPECT_EQ(radar.T_vehicle_radar.translation_m, sent.T_vehicle_radar.translation_m);
  EXPECT_LT(Log(radar.T_vehicle_radar.Inverse() * sent.T_vehicle_radar).norm(), 1e-12);
  EXPECT_EQ(radar.beta_s, sent.beta_s);
  EXPECT_EQ(radar.range_bias_m, sent.range_bias_m);
  EXPECT_EQ(radar.time_offset_s, sent.time_offset_s);
  EXPECT_EQ(radar.beta_sigma_s, sent.beta_sigma_s);
  EXPECT_EQ(radar.range_bias_sigma_m, sent.range_bias_sigma_m);
  EXPECT_EQ(radar.time_offset_sigma_s, sent.time_offset_sigma_s);
  EXPECT_EQ(radar.mount_yaw_sigma_rad, sent.mount_yaw_sigma_rad);
  EXPECT_EQ(radar.range_sigma_m, sent.range_sigma_m);
  EXPECT_EQ(radar.range_rate_sigma_mps, sent.range_rate_sigma_mps);
  EXPECT_EQ(radar.azimuth_sigma_rad, sent.azimuth_sigma_rad);
  EXPECT_EQ(radar.elevation_sigma_rad, sent.elevation_sigma_rad);
  EXPECT_TRUE(radar.has_elevation);
  EXPECT_EQ(radar.unambiguous_range_rate_mps, sent.unambiguous_range_rate_mps);
  EXPECT_FALSE(arrived->radars[1].has_elevation);
}

using google::protobuf::FieldDescriptor;
using google::protobuf::util::MessageDifferencer;

/// Gives each number and flag in `message` that is not one of `left_out` a value of its own, in
/// what is below too.
void Fill(const std::string& left_out, google::protobuf::Message* message, float* value) {
  const google::protobuf::Reflection& reflection = *message->GetReflection();
  for (int i = 0; i < message->GetDescriptor()->field_count(); ++i) {
    const FieldDescriptor* field = message->GetDescriptor()->field(i);
    if (field->name() == left_out) continue;
    switch (field->cpp_type()) {
      case FieldDescriptor::CPPTYPE_DOUBLE:
        ASSERT_FALSE(field->is_repeated());
        reflection.SetDouble(message, field, static_cast<double>(*value += 0.001F));
        break;
      case FieldDescriptor::CPPTYPE_FLOAT:
        reflection.AddFloat(message, field, *value += 0.001F);
        break;
      case FieldDescriptor::CPPTYPE_INT32:
        reflection.SetInt32(message, field, 7);
        break;
      case FieldDescriptor::CPPTYPE_INT64:
        if (field->is_repeated()) {
          reflection.AddInt64(message, field, -20'000'000);
        } else {
          reflection.SetInt64(message, field, 1'700'000'000'000'000'123);
        }
        break;
      case FieldDescriptor::CPPTYPE_BOOL:
        reflection.SetBool(message, field, true);
        break;
      case FieldDescriptor::CPPTYPE_STRING:
        reflection.SetString(message, field, "front");
        break;
      case FieldDescriptor::CPPTYPE_MESSAGE:
        Fill(left_out, reflection.MutableMessage(message, field), value);
        break;
      default:
        FAIL() << field->full_name() << " has a type that this test does not know";
    }
  }
}

/// A radar of which the wire says all that it can.
v1::Rig FullRig() {
  v1::Rig rig;
  float value = 0.1F;
  Fill("chirp", rig.add_radars(), &value);
  // Of length 1 to the last bit, so that nobody changes it.
  v1::Quaternion& rotation = *rig.mutable_radars(0)->mutable_t_vehicle_radar()->mutable_rotation();
  rotation = v1::Quaternion();
  rotation.set_z(1.0);
  return rig;
}

// Server and client each have a translation of their own, and this is what keeps them in step: a
// field that one of the three forgets comes back empty.
TEST(WireTest, NothingThatTheWireSaysOfARadarIsForgotten) {
  const v1::Rig rig = FullRig();
  const auto at_server = server::convert::FromProto(rig, "rig");
  ASSERT_TRUE(at_server.ok()) << at_server.status();
  EXPECT_TRUE(MessageDifferencer::Equals(ToProto(*at_server), rig))
      << ToProto(*at_server).DebugString() << "instead of\n"
      << rig.DebugString();
  v1::OpenSession open;
  *open.mutable_rig() = rig;
  const auto replayed = FromProto(open, std::nullopt);
  ASSERT_TRUE(replayed.ok()) << replayed.status();
  EXPECT_TRUE(MessageDifferencer::Equals(ToProto(replayed->rig), rig))
      << ToProto(replayed->rig).DebugString();
}

TEST(WireTest, NothingThatTheWireSaysOfAScanIsForgotten) {
  v1::Scan message;
  float value = 0.1F;
  Fill("covariance", &message, &value);
  Scan at_server;
  const absl::Status status = server::convert::FromProto(message, TwoRadars(), &at_server);
  ASSERT_TRUE(status.ok()) << status;
  const v1::Scan back = ToProto(at_server, message.sequence_number());
  EXPECT_TRUE(MessageDifferencer::Equals(back, message)) << back.DebugString();
  const v1::Scan replayed = ToProto(FromProto(message), message.sequence_number());
  EXPECT_TRUE(MessageDifferencer::Equals(replayed, message)) << replayed.DebugString();
}

TEST(WireTest, OptionsAreReplayedAsTheServerTookThem) {
  v1::OpenSession open;
  open.set_vehicle_id("car");
  open.set_map_name("town");
  *open.mutable_rig() = FullRig();
  const auto* options = v1::LocalizationOptions::descriptor();
  ASSERT_EQ(options->field_count(), 4) << "compare the new one below";
  open.mutable_options()->set_scans_per_submap(3);
  open.mutable_options()->set_doppler_compensation(false);
  open.mutable_options()->set_uncertainty(false);
  open.mutable_options()->set_truncation(false);
  const auto at_server = server::convert::FromProto(open);
  ASSERT_TRUE(at_server.ok()) << at_server.status();
  const auto replayed = FromProto(open, std::nullopt);
  ASSERT_TRUE(replayed.ok()) << replayed.status();
  for (const LocalizerOptions& taken : {at_server->options, replayed->options}) {
    EXPECT_EQ(taken.scans_per_submap, 3);
    EXPECT_FALSE(taken.doppler_compensation);
    EXPECT_FALSE(taken.per_point_covariance);
    EXPECT_FALSE(taken.gate_outliers);
  }
}

const GeodeticAnchor kAnchor{
    .origin = {.latitude_deg = 48.4, .longitude_deg = 9.97, .height_m = 480.0},
    .x_axis_east_rad = 0.5};

InitialPose Level() {
  const Pose3 pose{
      .translation_m = {120.0, -40.0, 1.0},
      .rotation = Eigen::Quaterniond(Eigen::AngleAxisd(-2.0, Eigen::Vector3d::UnitZ()))};
  Vector6d variances;
  variances << 0.5, 0.5, 0.01, 7e-5, 7e-5, 1e-3;
  return {.T_map_vehicle = pose, .covariance = variances.asDiagonal()};
}

TEST(WireTest, AFixIsThePoseThatItWasMadeOf) {
  v1::OpenSession open;
  *open.mutable_gnss_fix() = FixOf(Level(), kAnchor);
  const auto pose = server::convert::InitialPoseFromProto(open, kAnchor);
  ASSERT_TRUE(pose.ok()) << pose.status();
  EXPECT_LT(Log((*pose)->T_map_vehicle.Inverse() * Level().T_map_vehicle).norm(), 1e-5);
  for (const int i : {0, 1, 2, 5}) {
    EXPECT_NEAR((*pose)->covariance(i, i), Level().covariance(i, i), 1e-9) << i;
  }
}

TEST(WireTest, AFixIsReplayedToTheBit) {
  v1::OpenSession open;
  *open.mutable_gnss_fix() = FixOf(Level(), kAnchor);
  for (const bool has_heading : {true, false}) {
    if (!has_heading) {
      open.mutable_gnss_fix()->clear_heading_deg();
      open.mutable_gnss_fix()->clear_heading_sigma_deg();
    }
    const auto at_server = server::convert::InitialPoseFromProto(open, kAnchor);
    ASSERT_TRUE(at_server.ok()) << at_server.status();
    const auto replayed = FromProto(open, kAnchor);
    ASSERT_TRUE(replayed.ok()) << replayed.status();
    ASSERT_TRUE(replayed->initial_pose.has_value());
    const Pose3& pose = replayed->initial_pose->T_map_vehicle;
    EXPECT_EQ(pose.translation_m, (*at_server)->T_map_vehicle.translation_m);
    EXPECT_EQ(pose.rotation.coeffs(), (*at_server)->T_map_vehicle.rotation.coeffs());
    EXPECT_EQ(replayed->initial_pose->covariance, (*at_server)->covariance);
  }
  const absl::Status status = FromProto(open, std::nullopt).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status.message()), ::testing::HasSubstr("no anchor"));
}

TEST(WireTest, AScanArrivesAsItWas) {
  const Scan sent{.stamp = Stamp(std::chrono::nanoseconds(1'535'385'092'141'303'001)),
                  .radar_id = "front",
                  .range_m = {10.5F, 20.25F},
                  .range_rate_mps = {-3.0F, 4.0F},
                  .azimuth_rad = {0.1F, -0.2F},
                  .elevation_rad = {0.01F, 0.02F},
                  .rcs_dbsm = {5.0F, -5.0F},
                  .range_sigma_m = {0.1F, 0.2F},
                  .range_rate_sigma_mps = {0.3F, 0.4F},
                  .azimuth_sigma_rad = {0.01F, 0.02F},
                  .elevation_sigma_rad = {0.03F, 0.04F},
                  .ego_velocity = EgoVelocity{.linear_mps = {8.0, 0.1, 0.0},
                                              .angular_radps = {0.0, 0.0, 0.2},
                                              .covariance = 0.01 * Matrix6d::Identity()}};
  const v1::Scan message = ToProto(sent, 42);
  EXPECT_EQ(message.sequence_number(), 42);
  Scan scan;
  const absl::Status status = server::convert::FromProto(message, TwoRadars(), &scan);
  ASSERT_TRUE(status.ok()) << status;
  EXPECT_EQ(scan.stamp, sent.stamp);
  EXPECT_EQ(scan.radar_id, sent.radar_id);
  EXPECT_EQ(scan.range_m, sent.range_m);
  EXPECT_EQ(scan.range_rate_mps, sent.range_rate_mps);
  EXPECT_EQ(scan.azimuth_rad, sent.azimuth_rad);
  EXPECT_EQ(scan.elevation_rad, sent.elevation_rad);
  EXPECT_EQ(scan.rcs_dbsm, sent.rcs_dbsm);
  EXPECT_EQ(scan.range_sigma_m, sent.range_sigma_m);
  EXPECT_EQ(scan.range_rate_sigma_mps, sent.range_rate_sigma_mps);
  EXPECT_EQ(scan.azimuth_sigma_rad, sent.azimuth_sigma_rad);
  EXPECT_EQ(scan.elevation_sigma_rad, sent.elevation_sigma_rad);
  ASSERT_TRUE(scan.ego_velocity.has_value());
  EXPECT_EQ(scan.ego_velocity->linear_mps, sent.ego_velocity->linear_mps);
  EXPECT_EQ(scan.ego_velocity->angular_radps, sent.ego_velocity->angular_radps);
  EXPECT_EQ(scan.ego_velocity->covariance, sent.ego_velocity->covariance);
}

TEST(WireTest, AnInitialPoseArrivesAsItWas) {
  Vector6d variances;
  variances << 0.5, 0.4, 0.01, 1e-4, 2e-4, 1e-3;
  const InitialPose sent{.T_map_vehicle = Exp(Vector6d(0.4 * Vector6d::Ones())),
                         .covariance = variances.asDiagonal()};
  v1::OpenSession open;
  *open.mutable_initial_pose() = ToProto(sent);
  const auto arrived = server::convert::InitialPoseFromProto(open, std::nullopt);
  ASSERT_TRUE(arrived.ok()) << arrived.status();
  EXPECT_LT(Log((*arrived)->T_map_vehicle.Inverse() * sent.T_map_vehicle).norm(), 1e-12);
  EXPECT_LT(((*arrived)->covariance - sent.covariance).norm(), 1e-12);
}

TEST(WireTest, PositionFixesAreTakenAndReplayedToTheBit) {
  const Stamp stamp(std::chrono::nanoseconds(1'535'385'092'141'303'001));
  MapFix map_fix{.p_map = {10.0, 20.0, 1.0}, .horizontal_sigma_m = 2.0, .vertical_sigma_m = 4.0};
  GnssFix gnss_fix{.position = {.latitude_deg = 48.401, .longitude_deg = 9.971, .height_m = 480.0},
                   .horizontal_sigma_m = 1.5,
                   .vertical_sigma_m = 3.0,
                   .heading_deg = 77.0,
                   .heading_sigma_deg = 2.0};
  std::vector<StampedFix> fixes = {{stamp, map_fix}, {stamp, gnss_fix}};
  map_fix.yaw_deg = 30.0;
  map_fix.yaw_sigma_deg = 1.0;
  gnss_fix.heading_deg.reset();
  gnss_fix.heading_sigma_deg = 0.0;
  fixes.push_back({stamp, map_fix});
  fixes.push_back({stamp, gnss_fix});
  for (const StampedFix& fix : fixes) {
    const v1::PositionFix message = ToProto(fix);
    const auto at_server = server::convert::FromProto(message, kAnchor);
    ASSERT_TRUE(at_server.ok()) << at_server.status();
    const auto replayed = FromProto(message, kAnchor);
    ASSERT_TRUE(replayed.ok()) << replayed.status();
    for (const PositionFix& taken : {*at_server, *replayed}) {
      EXPECT_EQ(taken.stamp, stamp);
      EXPECT_EQ(taken.pose.T_map_vehicle.translation_m,
                at_server->pose.T_map_vehicle.translation_m);
      EXPECT_EQ(taken.pose.T_map_vehicle.rotation.coeffs(),
                at_server->pose.T_map_vehicle.rotation.coeffs());
      EXPECT_EQ(taken.pose.covariance, at_server->pose.covariance);
    }
    if (!message.has_map_pose()) continue;
    const InitialPose sent = PoseOf(std::get<MapFix>(fix.position));
    EXPECT_LT(Log(at_server->pose.T_map_vehicle.Inverse() * sent.T_map_vehicle).norm(), 1e-12);
    EXPECT_LT((at_server->pose.covariance - sent.covariance).norm(), 1e-12);
  }
  EXPECT_EQ(FromProto(ToProto(fixes[1]), std::nullopt).status().code(),
            absl::StatusCode::kFailedPrecondition);
}

Localization Answer() {
  return {.stamp = Stamp(std::chrono::nanoseconds(1'535'385'092'141'303'001)),
          .state = LocalizationState::kDeadReckoning,
          .T_map_vehicle = Exp(Vector6d(0.4 * Vector6d::Ones())),
          .covariance = 0.01 * Vector6d(1.0, 2.0, 3.0, 4.0, 5.0, 6.0).asDiagonal(),
          .observed = std::bitset<6>("100011"),
          .protection_level_m = 0.75,
          .health = {.wheel_speed = {.is_used = false, .fault = SourceFault::kSlip},
                     .yaw_rate = {.is_used = true, .fault = SourceFault::kNone},
                     .radars = {{.is_used = false, .fault = SourceFault::kMount},
                                {.is_used = true, .fault = SourceFault::kNone}}},
          .resets = {.count = 2, .T_before_after = Exp(Vector6d(0.1 * Vector6d::Ones()))},
          .quality = {.live_point_count = 7,
                      .inlier_count = 6,
                      .overlap = 0.5,
                      .residual_scale = 1.1,
                      .normalized_innovation_squared = 2.2,
                      .is_accepted = true,
                      .beta = {.error_s = 0.03, .sigma_s = 0.007, .is_wrong = true}}};
}

TEST(WireTest, AnAnswerArrivesAsItWas) {
  const Localization sent = Answer();
  v1::LocalizationResult result;
  server::convert::ToProto(sent, &result);
  server::convert::ToProto(sent.health, TwoRadars(), result.mutable_health());
  const auto answer = FromProto(result);
  ASSERT_TRUE(answer.ok()) << answer.status();
  EXPECT_EQ(answer->stamp, sent.stamp);
  EXPECT_EQ(answer->state, sent.state);
  EXPECT_EQ(answer->T_map_vehicle.translation_m, sent.T_map_vehicle.translation_m);
  EXPECT_EQ(answer->T_map_vehicle.rotation.coeffs(), sent.T_map_vehicle.rotation.coeffs());
  EXPECT_LT((answer->covariance - sent.covariance).norm(), 1e-15);
  EXPECT_EQ(answer->observed, sent.observed);
  EXPECT_EQ(answer->quality.live_point_count, 7);
  EXPECT_EQ(answer->quality.inlier_count, 6);
  EXPECT_EQ(answer->quality.overlap, 0.5);
  EXPECT_EQ(answer->quality.residual_scale, 1.1);
  EXPECT_EQ(answer->quality.normalized_innovation_squared, 2.2);
  EXPECT_TRUE(answer->quality.is_accepted);
  EXPECT_EQ(answer->quality.beta.error_s, 0.03);
  EXPECT_EQ(answer->quality.beta.sigma_s, 0.007);
  EXPECT_TRUE(answer->quality.beta.is_wrong);
  EXPECT_EQ(answer->protection_level_m, sent.protection_level_m);
  EXPECT_EQ(answer->health, sent.health);
  EXPECT_EQ(answer->resets.count, 2);
  EXPECT_EQ(answer->resets.T_before_after.translation_m, sent.resets.T_before_after.translation_m);
}

TEST(WireTest, AReplayedAnswerIsTheServersToTheBit) {
  Localization answer = Answer();
  for (const bool is_plain : {false, true}) {
    if (is_plain) {
      answer.protection_level_m.reset();
      answer.resets = {};
    }
    const server::LocalizedScan localized{.localization = answer,
                                          .rig = std::make_shared<const Rig>(TwoRadars())};
    const server::ScanAnswer scan{.sequence_number = 7, .result = localized};
    v1::LocalizeResponse at_server;
    server::convert::ToProto(scan, &at_server);
    v1::LocalizationResult result = at_server.result();
    result.clear_timings();
    EXPECT_EQ(ToProto(answer, TwoRadars(), 7).SerializeAsString(), result.SerializeAsString());
  }
}

TEST(WireTest, AnAnswerThatIsNoneIsAnError) {
  v1::LocalizationResult result;
  server::convert::ToProto(Answer(), &result);
  v1::LocalizationResult no_state = result;
  no_state.clear_state();
  EXPECT_EQ(FromProto(no_state).status().code(), absl::StatusCode::kDataLoss);
  v1::LocalizationResult short_covariance = result;
  short_covariance.mutable_pose()->mutable_covariance()->RemoveLast();
  EXPECT_EQ(FromProto(short_covariance).status().code(), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace dcloc::cli
