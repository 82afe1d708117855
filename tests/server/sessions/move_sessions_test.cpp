#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/server/fixtures/test_maps.h"
#include "tests/server/fixtures/test_server.h"
#include "tests/server/fixtures/town_drive.h"

// Running sessions that go on in another version of their map.
namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

class MovingTest : public ::testing::Test {
 protected:
  explicit MovingTest(const ServerConfig& config = TestServer::StubConfig()) : server_(config) {}

  void Upload(const std::vector<std::byte>& bytes, bool activate = false) {
    v1::UploadMapHeader header = HeaderOf(bytes);
    header.set_activate(activate);
    v1::UploadMapResponse response;
    const grpc::Status status = UploadMap(*server_.maps, header, bytes, &response);
    ASSERT_TRUE(status.ok()) << status.error_message();
  }

  int Activate(std::int64_t version, bool move_sessions = true) {
    Call call;
    v1::ActivateMapVersionRequest request;
    request.set_map_name("town");
    request.set_version(version);
    request.set_move_sessions(move_sessions);
    v1::ActivateMapVersionResponse response;
    const grpc::Status status = server_.maps->ActivateMapVersion(&call, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response.moved_session_count();
  }

  int RollBack() {
    Call call;
    v1::RollBackMapRequest request;
    request.set_map_name("town");
    request.set_move_sessions(true);
    v1::RollBackMapResponse response;
    const grpc::Status status = server_.maps->RollBackMap(&call, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response.moved_session_count();
  }

  grpc::Status Delete(std::int64_t version, bool drain) {
    Call call;
    v1::DeleteMapVersionRequest request;
    request.set_map_name("town");
    request.set_version(version);
    request.set_drain_sessions(drain);
    v1::DeleteMapVersionResponse response;
    return server_.maps->DeleteMapVersion(&call, request, &response);
  }

  grpc::Status DeleteMap(bool drain) {
    Call call;
    v1::DeleteMapRequest request;
    request.set_map_name("town");
    request.set_drain_sessions(drain);
    v1::DeleteMapResponse response;
    return server_.maps->DeleteMap(&call, request, &response);
  }

  std::unique_ptr<TestSession> OpenSession(const v1::OpenSession& open) {
    auto session = std::make_unique<TestSession>(*server_.localization);
    EXPECT_TRUE(session->Open(open));
    EXPECT_TRUE(session->Read().has_value());
    return session;
  }

  static v1::LocalizationResult Localize(TestSession& session, const v1::Scan& scan) {
    const auto answer = session.Localize(scan);
    EXPECT_TRUE(answer && answer->has_result()) << scan.sequence_number();
    return answer ? answer->result() : v1::LocalizationResult();
  }

  int LoadedMaps() {
    Call call;
    v1::GetServerStateResponse response;
    EXPECT_TRUE(server_.admin->GetServerState(&call, {}, &response).ok());
    return response.loaded_map_count();
  }

  TestServer server_;
};

TEST_F(MovingTest, SessionsMoveBetweenTwoScansAndTheirPoseGoesOn) {
  Upload(SmallMap("first"), true);
  Upload(SmallMap("second"));
  const auto session = OpenSession(OpenMessage());
  for (int i = 0; i < 5; ++i) Localize(*session, ScanMessage(i));
  EXPECT_EQ(Activate(2), 1);
  const v1::LocalizationResult moved = Localize(*session, ScanMessage(5));
  EXPECT_EQ(moved.map_version(), 2);
  EXPECT_NEAR(moved.pose().pose().translation_m().x(), 5 * 0.77, 1e-9)
      << "the way since the last scan is not lost";
  EXPECT_EQ(LoadedMaps(), 1) << "the old version's memory is released";
  EXPECT_EQ(Activate(2), 0) << "it is there already";
  EXPECT_EQ(RollBack(), 1);
  EXPECT_EQ(Localize(*session, ScanMessage(6)).map_version(), 1);
  Call call;
  v1::ListSessionsResponse sessions;
  ASSERT_TRUE(server_.admin->ListSessions(&call, {}, &sessions).ok());
  EXPECT_EQ(sessions.sessions(0).map_version(), 1);
}

TEST_F(MovingTest, OnlyThoseAreMovedWhoShallBe) {
  Upload(SmallMap("first"), true);
  Upload(SmallMap("second"));
  v1::UploadMapHeader header = HeaderOf(SmallMap("first"));
  header.set_map_name("city");
  v1::UploadMapResponse response;
  ASSERT_TRUE(UploadMap(*server_.maps, header, SmallMap("first"), &response).ok());
  v1::OpenSession asks = OpenMessage();
  asks.set_map_version(1);
  v1::OpenSession elsewhere = OpenMessage();
  elsewhere.set_map_name("city");
  const auto pinned = OpenSession(asks);
  const auto in_city = OpenSession(elsewhere);
  const auto free = OpenSession(OpenMessage());
  EXPECT_EQ(Activate(2, /*move_sessions=*/false), 0);
  EXPECT_EQ(Localize(*free, ScanMessage(0)).map_version(), 1);
  EXPECT_EQ(Activate(2), 1);
  EXPECT_EQ(Localize(*free, ScanMessage(1)).map_version(), 2);
  EXPECT_EQ(Localize(*pinned, ScanMessage(0)).map_version(), 1);
  EXPECT_EQ(Localize(*in_city, ScanMessage(0)).map_version(), 1);
}

TEST_F(MovingTest, ADrainedVersionIsDeletedAndWhoCanGoesOnInAnotherOne) {
  Upload(SmallMap("first"), true);
  Upload(SmallMap("second"));
  v1::OpenSession asks = OpenMessage();
  asks.set_map_version(1);
  v1::OpenSession asks_for_another = OpenMessage();
  asks_for_another.set_map_version(2);
  const auto pinned = OpenSession(asks);
  const auto beside = OpenSession(asks_for_another);
  const auto free = OpenSession(OpenMessage());
  Localize(*free, ScanMessage(0));
  Activate(2, /*move_sessions=*/false);
  const grpc::Status in_use = Delete(1, /*drain=*/false);
  EXPECT_EQ(in_use.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_THAT(in_use.error_message(), HasSubstr("in use"));

  const grpc::Status drained = Delete(1, /*drain=*/true);
  EXPECT_TRUE(drained.ok()) << drained.error_message();
  EXPECT_EQ(LoadedMaps(), 1);
  EXPECT_EQ(Localize(*free, ScanMessage(1)).map_version(), 2);
  EXPECT_EQ(Localize(*beside, ScanMessage(0)).map_version(), 2);
  const grpc::Status ended = pinned->Finish();
  EXPECT_EQ(ended.error_code(), grpc::StatusCode::ABORTED);
  EXPECT_THAT(ended.error_message(), HasSubstr("being deleted"));
}

TEST_F(MovingTest, TheActiveVersionIsNotDrained) {
  Upload(SmallMap("first"), true);
  const auto session = OpenSession(OpenMessage());
  const grpc::Status status = Delete(1, /*drain=*/true);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_THAT(status.error_message(), HasSubstr("version 1 of map \"town\" is active"));
  EXPECT_EQ(Localize(*session, ScanMessage(0)).map_version(), 1);
}

TEST_F(MovingTest, AVersionWhoseSessionsCannotMoveIsDrainedByEndingThem) {
  Upload(SmallMap("first"), true);
  SyntheticMap anchored(12, 20);
  anchored.info.flags |= kHasAnchorFlag;
  anchored.info.anchor_latitude_deg = 52.5;
  Upload(anchored.Bytes());
  v1::OpenSession open = OpenMessage();
  open.set_resumable(true);
  const auto session = OpenSession(open);
  Localize(*session, ScanMessage(0));
  Activate(2, /*move_sessions=*/false);
  EXPECT_TRUE(Delete(1, /*drain=*/true).ok());
  const auto ending = session->Read();
  ASSERT_TRUE(ending && ending->has_ending());
  EXPECT_EQ(ending->ending().reason(), v1::SESSION_END_REASON_OPERATOR);
  EXPECT_EQ(session->Finish().error_code(), grpc::StatusCode::ABORTED);
}

TEST_F(MovingTest, ADrainedMapIsDeletedWithItsSessions) {
  Upload(SmallMap("first"), true);
  const auto session = OpenSession(OpenMessage());
  EXPECT_EQ(DeleteMap(/*drain=*/false).error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_TRUE(DeleteMap(/*drain=*/true).ok());
  EXPECT_EQ(session->Finish().error_code(), grpc::StatusCode::ABORTED);
  EXPECT_EQ(LoadedMaps(), 0);
}

TEST_F(MovingTest, AMalformedScanBeforeTheMoveDoesNoHarm) {
  Upload(SmallMap("first"), true);
  Upload(SmallMap("second"));
  const auto session = OpenSession(OpenMessage());
  for (int i = 0; i < 3; ++i) Localize(*session, ScanMessage(i));
  v1::Scan malformed = ScanMessage(3);
  malformed.mutable_range_m()->Clear();
  ASSERT_TRUE(session->Localize(malformed)->has_rejected());
  EXPECT_EQ(Activate(2), 1);
  EXPECT_NEAR(Localize(*session, ScanMessage(3)).pose().pose().translation_m().x(), 3 * 0.77, 1e-9);
}

TEST_F(MovingTest, AVersionThatLiesElsewhereOnTheEarthKeepsTheSessionWhereItIs) {
  Upload(SmallMap("first"), true);
  SyntheticMap anchored(12, 20);
  anchored.info.flags |= kHasAnchorFlag;
  anchored.info.anchor_latitude_deg = 52.5;
  Upload(anchored.Bytes());
  const auto session = OpenSession(OpenMessage());
  Localize(*session, ScanMessage(0));
  EXPECT_EQ(Activate(2), 1) << "told to";
  EXPECT_EQ(Localize(*session, ScanMessage(1)).map_version(), 1);
}

TEST_F(MovingTest, ARecordedSessionStaysWhereItIs) {
  Upload(SmallMap("first"), true);
  Upload(SmallMap("second"));
  Call call;
  v1::RecordSessionRequest request;
  request.set_vehicle_id("car-1");
  const auto recorder = server_.admin->RecordSession(&call, request);
  recorder->WaitForInitialMetadata();
  const auto session = OpenSession(OpenMessage());
  Localize(*session, ScanMessage(0));
  EXPECT_EQ(Activate(2), 0);
  EXPECT_EQ(Localize(*session, ScanMessage(1)).map_version(), 1) << "a recording is of one version";
}

class MovingMatchTest : public MovingTest {
 protected:
  MovingMatchTest() : MovingTest(ServerConfig{}) {}

  static double Distance(const v1::LocalizationResult& a, const Pose3& b) {
    const v1::Vector3& p = a.pose().pose().translation_m();
    return std::hypot(p.x() - b.translation_m.x(), p.y() - b.translation_m.y());
  }
};

TEST_F(MovingMatchTest, TheLastScanIsNotTakenTwice) {
  const TownDrive drive;
  Upload(drive.map, true);
  Upload(drive.Map("town again"));
  const std::vector<v1::Scan> scans = drive.Scans();
  const auto moves = OpenSession(drive.Open());
  for (int i = 0; i < 3; ++i) Localize(*moves, scans[static_cast<std::size_t>(i)]);
  EXPECT_EQ(Activate(2), 1);
  const int moved = Localize(*moves, scans[3]).quality().live_point_count();
  const auto begins = OpenSession(drive.Open());
  EXPECT_EQ(moved, Localize(*begins, scans[3]).quality().live_point_count())
      << "its points are in the prior already";
  EXPECT_GT(moved, 0);
}

TEST_F(MovingMatchTest, APoseDoesNotJumpBeyondItsCovarianceAndIsTrackedAgain) {
  const TownDrive drive;
  Upload(drive.map, true);
  Upload(drive.Map("town again"));
  const auto stays = OpenSession([&] {
    v1::OpenSession open = drive.Open();
    open.set_map_version(1);
    return open;
  }());
  const auto moves = OpenSession(drive.Open());
  const std::size_t move_at = drive.live.scans.size() / 2;
  std::optional<std::size_t> tracked_at;
  for (std::size_t i = 0; i < drive.live.scans.size(); ++i) {
    if (i == move_at) {
      EXPECT_EQ(Activate(2), 1);
    }
    const auto scan = MessageOf(drive.live.scans[i].scan, static_cast<std::int64_t>(i));
    const v1::LocalizationResult unmoved = Localize(*stays, scan);
    const v1::LocalizationResult moved = Localize(*moves, scan);
    EXPECT_EQ(moved.map_version(), i < move_at ? 1 : 2);
    if (i < move_at) {
      EXPECT_EQ(moved.pose().SerializeAsString(), unmoved.pose().SerializeAsString());
      continue;
    }
    const double variance_m2 = moved.pose().covariance(0) + moved.pose().covariance(7) +
                               unmoved.pose().covariance(0) + unmoved.pose().covariance(7);
    const v1::Vector3& p = unmoved.pose().pose().translation_m();
    const Pose3 there{.translation_m = {p.x(), p.y(), p.z()}};
    EXPECT_LT(Distance(moved, there), 3.0 * std::sqrt(variance_m2)) << i;
    EXPECT_LT(Distance(moved, drive.live.scans[i].T_map_vehicle), 1.0) << i;
    if (moved.state() == v1::LOCALIZATION_STATE_TRACKING && !tracked_at) tracked_at = i;
  }
  ASSERT_TRUE(tracked_at.has_value());
  EXPECT_LE(*tracked_at - move_at, 15U) << "a sub-map later";
}

}  // namespace
}  // namespace dcloc::server
