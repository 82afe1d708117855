#include "client/sdk/c/dcloc.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <thread>

#include "tests/client/sdk/fake_server.h"
#include "tests/client/sdk/pose/answers.h"

namespace dcloc::client {
namespace {

using ::testing::HasSubstr;

constexpr std::array<double, 6> kDriving = {20.0, 0.0, 0.0, 0.0, 0.0, 0.0};

/// Answers each scan with a pose at x = the scan's number; refuses those of the radar "broken".
grpc::Status Answer(grpc::ServerContext&, LocalizeServerStream& stream) {
  AcceptOpen(stream);
  v1::LocalizeRequest request;
  while (stream.Read(&request)) {
    const v1::Scan& scan = request.scan();
    v1::LocalizeResponse response;
    if (scan.radar_id() == "broken") {
      response.mutable_rejected()->set_sequence_number(scan.sequence_number());
      response.mutable_rejected()->set_code(3);
      response.mutable_rejected()->set_message("range_m[0] is -1");
    } else {
      *response.mutable_result() = AnswerAt(0, static_cast<double>(scan.sequence_number()));
      response.mutable_result()->set_stamp_ns(scan.stamp_ns());
      response.mutable_result()->set_sequence_number(scan.sequence_number());
      response.mutable_result()->set_protection_level_m(scan.range_m_size());
    }
    stream.Write(response);
  }
  return grpc::Status::OK;
}

class DclocTest : public ::testing::Test {
 protected:
  dcloc_status Open(const char* address) {
    config_.reset(dcloc_config_new(address, "town", "car"));
    EXPECT_EQ(dcloc_config_set_reconnect_ms(config_.get(), 0), DCLOC_OK);
    dcloc_session* session = nullptr;
    const dcloc_status status = dcloc_session_open(config_.get(), &session);
    session_.reset(session);
    return status;
  }

  static dcloc_scan ScanAt(std::int64_t number, const char* radar_id = "front") {
    dcloc_scan scan{};
    scan.struct_size = sizeof scan;
    scan.sequence_number = number;
    scan.stamp_ns = At(100 * number);
    scan.radar_id = radar_id;
    return scan;
  }

  dcloc_answer Next() {
    dcloc_answer answer{};
    answer.struct_size = sizeof answer;
    EXPECT_EQ(dcloc_session_next(session_.get(), &answer), DCLOC_OK) << dcloc_error_text();
    return answer;
  }

  const FakeServer server_{Answer};
  std::unique_ptr<dcloc_config, decltype(&dcloc_config_free)> config_{nullptr, &dcloc_config_free};
  std::unique_ptr<dcloc_session, decltype(&dcloc_session_free)> session_{nullptr,
                                                                         &dcloc_session_free};
};

TEST_F(DclocTest, AScanIsAnsweredAndThePoseGoesOn) {
  ASSERT_EQ(Open(server_.address().c_str()), DCLOC_OK) << dcloc_error_text();
  dcloc_pose pose{};
  pose.struct_size = sizeof pose;
  EXPECT_EQ(dcloc_session_pose_at(session_.get(), At(0), &pose), DCLOC_FAILED_PRECONDITION);
  EXPECT_THAT(dcloc_error_text(), HasSubstr("no answer"));

  const std::array<float, 3> column = {1.0F, 2.0F, 3.0F};
  dcloc_scan scan = ScanAt(7);
  scan.target_count = column.size();
  scan.range_m = scan.range_rate_mps = scan.azimuth_rad = column.data();
  scan.ego_velocity = kDriving.data();
  ASSERT_EQ(dcloc_session_send_scan(session_.get(), &scan), DCLOC_OK);
  const dcloc_answer answer = Next();
  EXPECT_EQ(answer.sequence_number, 7);
  EXPECT_EQ(answer.rejection, DCLOC_OK);
  EXPECT_EQ(answer.protection_level_m, 3.0);  // as many targets as arrived
  EXPECT_EQ(answer.pose.translation_m[0], 7.0);
  EXPECT_EQ(answer.pose.state, DCLOC_STATE_TRACKING);
  EXPECT_EQ(answer.pose.covariance[35], 0.0001);

  ASSERT_EQ(dcloc_session_pose_at(session_.get(), At(750), &pose), DCLOC_OK);
  EXPECT_NEAR(pose.translation_m[0], 8.0, 1e-9);
  EXPECT_NEAR(pose.velocity[0], 20.0, 1e-9);
  EXPECT_EQ(pose.answer_stamp_ns, At(700));
  ASSERT_EQ(dcloc_session_smooth_pose_at(session_.get(), At(750), &pose), DCLOC_OK);
  EXPECT_NEAR(pose.translation_m[0], 8.0, 1e-9);
  ASSERT_EQ(dcloc_session_add_ego_velocity(session_.get(), At(710), kDriving.data()), DCLOC_OK);
  EXPECT_EQ(dcloc_session_pose_at(session_.get(), At(5000), &pose), DCLOC_OUT_OF_RANGE);

  ASSERT_EQ(dcloc_session_add_motion(session_.get(), At(720), 30.0, NAN), DCLOC_OK);
  ASSERT_EQ(dcloc_session_add_motion(session_.get(), At(720), NAN, 0.0), DCLOC_OK);
  ASSERT_EQ(dcloc_session_pose_at(session_.get(), At(720), &pose), DCLOC_OK);
  EXPECT_NEAR(pose.velocity[0], 30.0, 1e-9);
  EXPECT_EQ(dcloc_session_add_motion(session_.get(), At(730), NAN, NAN), DCLOC_INVALID_ARGUMENT);
  EXPECT_THAT(dcloc_error_text(), ::testing::HasSubstr("neither"));
}

TEST_F(DclocTest, ARefusedScanSaysWhy) {
  ASSERT_EQ(Open(server_.address().c_str()), DCLOC_OK);
  const dcloc_scan scan = ScanAt(1, "broken");
  ASSERT_EQ(dcloc_session_send_scan(session_.get(), &scan), DCLOC_OK);
  const dcloc_answer answer = Next();
  EXPECT_EQ(answer.sequence_number, 1);
  EXPECT_EQ(answer.rejection, DCLOC_INVALID_ARGUMENT);
  EXPECT_STREQ(dcloc_error_text(), "range_m[0] is -1");
}

TEST_F(DclocTest, ASessionEndsWell) {
  ASSERT_EQ(Open(server_.address().c_str()), DCLOC_OK);
  EXPECT_EQ(dcloc_session_end_status(session_.get()), DCLOC_FAILED_PRECONDITION);
  ASSERT_EQ(dcloc_session_close_sending(session_.get()), DCLOC_OK);
  dcloc_answer answer{};
  answer.struct_size = sizeof answer;
  EXPECT_EQ(dcloc_session_next(session_.get(), &answer), DCLOC_OUT_OF_RANGE);
  EXPECT_EQ(dcloc_session_end_status(session_.get()), DCLOC_OK);
  const dcloc_scan scan = ScanAt(1);
  EXPECT_EQ(dcloc_session_send_scan(session_.get(), &scan), DCLOC_FAILED_PRECONDITION);
  EXPECT_EQ(dcloc_session_cancel(session_.get()), DCLOC_OK);
}

TEST_F(DclocTest, WhatCannotBeOpenedSaysWhy) {
  EXPECT_EQ(Open("no port"), DCLOC_INVALID_ARGUMENT) << dcloc_error_text();
  EXPECT_EQ(session_, nullptr);
  const std::string text = dcloc_error_text();
  EXPECT_FALSE(text.empty());
  std::thread([] { EXPECT_STREQ(dcloc_error_text(), ""); }).join();  // it is the thread's own
  EXPECT_EQ(dcloc_error_text(), text);
}

TEST_F(DclocTest, NullAndSizesThatCannotBeAreRefused) {
  dcloc_session* session = nullptr;
  EXPECT_EQ(dcloc_session_open(nullptr, &session), DCLOC_INVALID_ARGUMENT);
  EXPECT_STREQ(dcloc_error_text(), "config is NULL");
  EXPECT_EQ(dcloc_config_add_radar(nullptr, "front", nullptr, nullptr, 0.0),
            DCLOC_INVALID_ARGUMENT);
  EXPECT_EQ(dcloc_session_cancel(nullptr), DCLOC_INVALID_ARGUMENT);
  dcloc_config_free(nullptr);
  dcloc_session_free(nullptr);
  ASSERT_EQ(Open(server_.address().c_str()), DCLOC_OK);
  EXPECT_EQ(dcloc_session_send_scan(session_.get(), nullptr), DCLOC_INVALID_ARGUMENT);
  dcloc_scan scan = ScanAt(1);
  scan.radar_id = nullptr;
  EXPECT_EQ(dcloc_session_send_scan(session_.get(), &scan), DCLOC_INVALID_ARGUMENT);
  dcloc_pose pose{};
  EXPECT_EQ(dcloc_session_pose_at(session_.get(), At(0), &pose), DCLOC_INVALID_ARGUMENT);
  EXPECT_THAT(dcloc_error_text(), HasSubstr("dcloc_pose.struct_size is 0"));
}

}  // namespace
}  // namespace dcloc::client
