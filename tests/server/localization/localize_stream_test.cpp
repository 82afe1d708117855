#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/fixtures/test_maps.h"
#include "tests/server/fixtures/test_server.h"

namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

/// The stub localizer: what is tested here is all but the method.
class LocalizeTest : public ::testing::Test {
 protected:
  LocalizeTest() : LocalizeTest(TestServer::StubConfig()) {}
  explicit LocalizeTest(const ServerConfig& config) : server_(config) {
    v1::UploadMapResponse response;
    const std::vector<std::byte> bytes = SmallMap();
    const grpc::Status status = UploadMap(*server_.maps, HeaderOf(bytes), bytes, &response);
    if (!status.ok()) throw std::runtime_error(status.error_message());
  }

  /// Opens a session and reads `opened`.
  void OpenSession(TestSession& session, const v1::OpenSession& open = OpenMessage()) {
    ASSERT_TRUE(session.Open(open));
    const auto opened = session.Read();
    ASSERT_TRUE(opened.has_value()) << session.Finish().error_message();
    ASSERT_TRUE(opened->has_opened());
  }

  v1::GetServerStateResponse State() {
    Call call;
    v1::GetServerStateResponse response;
    EXPECT_TRUE(server_.admin->GetServerState(&call, {}, &response).ok());
    return response;
  }

  TestServer server_;
};

TEST_F(LocalizeTest, AnswersEachScanInOrder) {
  TestSession session(*server_.localization);
  ASSERT_TRUE(session.Open(OpenMessage()));
  const auto opened = session.Read();
  ASSERT_TRUE(opened.has_value());
  EXPECT_EQ(opened->opened().session_id().size(), 32U);
  EXPECT_EQ(opened->opened().map_name(), "town");
  EXPECT_EQ(opened->opened().map_version(), 1);
  for (int i = 0; i < 50; ++i) {
    const auto answer = session.Localize(ScanMessage(i));
    ASSERT_TRUE(answer.has_value());
    ASSERT_TRUE(answer->has_result()) << answer->ShortDebugString();
    const v1::LocalizationResult& result = answer->result();
    EXPECT_EQ(result.sequence_number(), i);
    EXPECT_EQ(result.stamp_ns(), ScanMessage(i).stamp_ns());
    EXPECT_EQ(result.state(), v1::LOCALIZATION_STATE_DEAD_RECKONING);
    EXPECT_NEAR(result.pose().pose().translation_m().x(), i * 0.77, 1e-9);
    EXPECT_EQ(result.pose().covariance_size(), 36);
    EXPECT_EQ(result.map_version(), 1);
    EXPECT_GT(result.timings().total_duration_ns(), 0);
    EXPECT_GE(result.timings().total_duration_ns(), result.timings().conversion_duration_ns());
  }
  session.CloseSending();
  EXPECT_TRUE(session.Finish().ok());
}

TEST_F(LocalizeTest, AnswersAllThatWasSentBeforeHalfClose) {
  TestSession session(*server_.localization);
  OpenSession(session);
  constexpr int kScans = 300;  // far more than a session has slots
  std::thread writer([&] {
    for (int i = 0; i < kScans; ++i) ASSERT_TRUE(session.Send(ScanMessage(i)));
    session.CloseSending();
  });
  for (int i = 0; i < kScans; ++i) {
    const auto answer = session.Read();
    ASSERT_TRUE(answer.has_value());
    ASSERT_EQ(answer->result().sequence_number(), i);
  }
  EXPECT_FALSE(session.Read().has_value());
  writer.join();
  EXPECT_TRUE(session.Finish().ok());
}

TEST_F(LocalizeTest, AnEmptyScanIsAnswered) {
  TestSession session(*server_.localization);
  OpenSession(session);
  const auto answer = session.Localize(ScanMessage(1, 0));
  ASSERT_TRUE(answer.has_value());
  EXPECT_TRUE(answer->has_result());
}

// ---- Scans that are refused

TEST_F(LocalizeTest, ARefusedScanChangesNothingAndTheSessionGoesOn) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<std::pair<std::string, std::function<void(v1::Scan*)>>> faults = {
      {"scan.range_m[0]", [](auto* s) { s->set_range_m(0, kNan); }},
      {"scan.azimuth_rad", [](auto* s) { s->mutable_azimuth_rad()->RemoveLast(); }},
      {"scan.radar_id", [](auto* s) { s->set_radar_id("nobody"); }},
      {"scan.stamp_ns", [](auto* s) { s->set_stamp_ns(0); }},
      {"stamp", [](auto* s) { s->set_stamp_ns(5); }},
      {"scan.stamp_ns", [](auto* s) { s->set_stamp_ns(5'000'000'000'000'000'000); }},
      {"scan.ego_velocity",
       [](auto* s) { s->mutable_ego_velocity()->mutable_linear_mps()->set_x(1e6); }},
      {"scan.sequence_number",
       [](auto* s) {
         *s = v1::Scan();
         s->set_sequence_number(-1);
       }},
  };
  TestSession session(*server_.localization);
  OpenSession(session);
  ASSERT_TRUE(session.Localize(ScanMessage(0))->has_result());
  std::int64_t number = 1;
  for (const auto& [named, spoil] : faults) {
    v1::Scan scan = ScanMessage(number);
    spoil(&scan);
    const auto answer = session.Localize(scan);
    ASSERT_TRUE(answer.has_value()) << named;
    ASSERT_TRUE(answer->has_rejected()) << named;
    EXPECT_EQ(answer->rejected().sequence_number(), scan.sequence_number());
    EXPECT_EQ(answer->rejected().code(), grpc::StatusCode::INVALID_ARGUMENT);
    EXPECT_THAT(answer->rejected().message(), HasSubstr(named));
    // The number is still free, the pose is where it would be without the refused scan.
    const auto next = session.Localize(ScanMessage(number));
    ASSERT_TRUE(next.has_value());
    ASSERT_TRUE(next->has_result()) << next->ShortDebugString();
    EXPECT_NEAR(next->result().pose().pose().translation_m().x(),
                static_cast<double>(number) * 0.77, 1e-9);
    ++number;
  }
  EXPECT_EQ(State().rejected_scan_count(), static_cast<int>(faults.size()));
}

// ---- What ends a session

grpc::Status StatusOfOpen(TestServer& server, const v1::OpenSession& open) {
  TestSession session(*server.localization);
  session.Open(open);
  return session.Finish();
}

TEST_F(LocalizeTest, ABadOpenEndsTheStreamWithItsReason) {
  v1::OpenSession open = OpenMessage();
  open.mutable_rig()->mutable_radars(0)->clear_t_vehicle_radar();
  const grpc::Status status = StatusOfOpen(server_, open);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("open.rig.radars[0].t_vehicle_radar"));
}

TEST_F(LocalizeTest, AnUnknownMapIsNotFound) {
  v1::OpenSession open = OpenMessage();
  open.set_map_name("atlantis");
  const grpc::Status status = StatusOfOpen(server_, open);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_THAT(status.error_message(), AllOf(HasSubstr("open.map"), HasSubstr("atlantis")));
  open = OpenMessage();
  open.set_map_version(12);
  EXPECT_EQ(StatusOfOpen(server_, open).error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(LocalizeTest, AFixInAMapWithoutAnchorIsAFailedPrecondition) {
  v1::OpenSession open = OpenMessage();
  v1::GnssFix* fix = open.mutable_gnss_fix();
  fix->mutable_position()->set_latitude_deg(1.0);
  fix->set_horizontal_sigma_m(1.0);
  fix->set_vertical_sigma_m(1.0);
  EXPECT_EQ(StatusOfOpen(server_, open).error_code(), grpc::StatusCode::FAILED_PRECONDITION);
}

TEST_F(LocalizeTest, AScanBeforeOpenEndsTheStream) {
  TestSession session(*server_.localization);
  session.Send(ScanMessage(1));
  const grpc::Status status = session.Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("open is missing"));
}

TEST_F(LocalizeTest, ASecondOpenEndsTheStreamAfterTheAnswersBeforeIt) {
  TestSession session(*server_.localization);
  OpenSession(session);
  ASSERT_TRUE(session.Send(ScanMessage(1)));
  ASSERT_TRUE(session.Open(OpenMessage()));
  const auto answer = session.Read();
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(answer->result().sequence_number(), 1);
  const grpc::Status status = session.Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("open came twice"));
}

TEST_F(LocalizeTest, AnEmptyMessageEndsTheStream) {
  TestSession session(*server_.localization);
  OpenSession(session);
  session.Send(v1::LocalizeRequest());
  const grpc::Status status = session.Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("message is missing"));
}

TEST_F(LocalizeTest, HalfCloseWithoutAMessageEndsWell) {
  TestSession session(*server_.localization);
  session.CloseSending();
  EXPECT_TRUE(session.Finish().ok());
}

TEST_F(LocalizeTest, AnOversizeMessageEndsItsStreamOnly) {
  TestSession other(*server_.localization);
  OpenSession(other);
  TestSession session(*server_.localization);
  OpenSession(session);
  session.Send(ScanMessage(1, 200'000));
  EXPECT_EQ(session.Finish().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_TRUE(other.Localize(ScanMessage(1))->has_result());
}

TEST_F(LocalizeTest, ManyMalformedStreamsDoNotDisturbAnother) {
  TestSession good(*server_.localization);
  OpenSession(good);
  std::atomic<int> vandal_count = 4;
  std::vector<std::thread> vandals;
  vandals.reserve(4);
  for (int kind = 0; kind < 4; ++kind) {
    vandals.emplace_back([&, kind] {
      for (int round = 0; round < 100; ++round) {
        TestSession session(*server_.localization);
        v1::OpenSession open = OpenMessage();
        if (kind == 0) open.clear_rig();
        if (kind == 1) session.Send(ScanMessage(1));
        session.Open(open);
        v1::Scan scan = ScanMessage(1);
        scan.mutable_azimuth_rad()->Clear();
        if (kind >= 2) session.Send(scan);
        if (kind == 3) session.Cancel();
        session.CloseSending();
        session.Finish();
      }
      --vandal_count;
    });
  }
  for (int i = 0; vandal_count > 0; ++i) {
    const auto answer = good.Localize(ScanMessage(i));
    const bool answered = answer && answer->has_result();
    EXPECT_TRUE(answered) << i;
    if (!answered) break;
    EXPECT_NEAR(answer->result().pose().pose().translation_m().x(), i * 0.77, 1e-6);
  }
  for (std::thread& vandal : vandals) vandal.join();
  good.CloseSending();
  EXPECT_TRUE(good.Finish().ok());
}

// ---- Cancelling, limits, and what is left behind

TEST_F(LocalizeTest, CancelledStreamsLeaveNothingBehind) {
  for (int round = 0; round < 50; ++round) {
    TestSession session(*server_.localization);
    session.Open(OpenMessage());
    if (round % 3 != 0) session.Read();
    for (int i = 0; i < round % 7; ++i) session.Send(ScanMessage(i));
    session.Cancel();
    EXPECT_EQ(session.Finish().error_code(), grpc::StatusCode::CANCELLED);
  }
  EXPECT_TRUE(Eventually([&] {
    const v1::GetServerStateResponse state = State();
    return state.session_count() == 0 && state.loaded_map_count() == 0;
  }));
}

TEST_F(LocalizeTest, AnEndedSessionLetsGoOfItsMapBeforeTheClientHearsOfIt) {
  v1::UploadMapResponse response;
  const std::vector<std::byte> bytes = SmallMap("second");
  ASSERT_TRUE(UploadMap(*server_.maps, HeaderOf(bytes), bytes, &response).ok());
  v1::DeleteMapVersionRequest request;
  request.set_map_name("town");
  request.set_version(1);
  v1::DeleteMapVersionResponse deleted;
  TestSession session(*server_.localization);
  v1::OpenSession open = OpenMessage();
  open.set_map_version(1);
  OpenSession(session, open);
  {
    Call call;
    const grpc::Status status = server_.maps->DeleteMapVersion(&call, request, &deleted);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
    EXPECT_THAT(status.error_message(), HasSubstr("in use"));
  }
  EXPECT_TRUE(session.Localize(ScanMessage(1))->has_result()) << "and the session goes on";
  session.CloseSending();
  ASSERT_TRUE(session.Finish().ok());
  Call call;
  const grpc::Status status = server_.maps->DeleteMapVersion(&call, request, &deleted);
  EXPECT_TRUE(status.ok()) << status.error_message();
}

TEST_F(LocalizeTest, ARunningSessionKeepsItsVersion) {
  TestSession session(*server_.localization);
  OpenSession(session);
  v1::UploadMapResponse response;
  const std::vector<std::byte> bytes = SmallMap("second");
  ASSERT_TRUE(UploadMap(*server_.maps, HeaderOf(bytes), bytes, &response).ok());
  ASSERT_EQ(response.version().version(), 2);
  EXPECT_EQ(session.Localize(ScanMessage(1))->result().map_version(), 1);
  TestSession later(*server_.localization);
  OpenSession(later);
  EXPECT_EQ(later.Localize(ScanMessage(1))->result().map_version(), 2);
}

TEST_F(LocalizeTest, AReaderThatNeverReadsHoldsItselfBackAndNobodyElse) {
  TestSession stuck(*server_.localization);
  OpenSession(stuck);
  std::atomic<int> sent = 0;
  std::thread writer([&] {
    while (stuck.Send(ScanMessage(sent, 2000))) ++sent;
  });
  ASSERT_TRUE(Eventually([&] { return StandsStill(sent); })) << "flow control must stop it";
  TestSession other(*server_.localization);
  OpenSession(other);
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(other.Localize(ScanMessage(i))->has_result());
  stuck.Cancel();
  writer.join();
  EXPECT_EQ(stuck.Finish().error_code(), grpc::StatusCode::CANCELLED);
}

class FewSessionsTest : public LocalizeTest {
 protected:
  static ServerConfig Config() {
    ServerConfig config = TestServer::StubConfig();
    config.max_session_count = 2;
    return config;
  }
  FewSessionsTest() : LocalizeTest(Config()) {}
};

TEST_F(FewSessionsTest, BeyondTheLimitSessionsAreRefused) {
  TestSession first(*server_.localization);
  OpenSession(first);
  {
    TestSession second(*server_.localization);
    OpenSession(second);
    const grpc::Status status = StatusOfOpen(server_, OpenMessage());
    EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
    EXPECT_THAT(status.error_message(), HasSubstr("2 sessions"));
    second.CloseSending();
    EXPECT_TRUE(second.Finish().ok());
  }
  EXPECT_TRUE(Eventually([&] {
    TestSession third(*server_.localization);
    return third.Open(OpenMessage()) && third.Read().has_value();
  }));
}

}  // namespace
}  // namespace dcloc::server
