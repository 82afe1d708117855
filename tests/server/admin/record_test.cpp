#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "server/app/storage.h"
#include "tests/server/fixtures/test_maps.h"
#include "tests/server/fixtures/test_server.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

/// A RecordSession call that the server has taken.
struct Recorder {
  Recorder(v1::AdminService::Stub& admin, const std::string& vehicle_id,
           const std::string& token = "", bool position_fixes = true) {
    if (!token.empty()) call.AddMetadata("authorization", "Bearer " + token);
    v1::RecordSessionRequest request;
    request.set_vehicle_id(vehicle_id);
    request.set_position_fixes(position_fixes);
    reader = admin.RecordSession(&call, request);
    reader->WaitForInitialMetadata();
  }

  std::optional<v1::RecordSessionResponse> Read() {
    v1::RecordSessionResponse message;
    return reader->Read(&message) ? std::optional(std::move(message)) : std::nullopt;
  }

  grpc::Status Finish() {
    while (Read()) {
    }
    return reader->Finish();
  }

  Call call;
  std::unique_ptr<grpc::ClientReader<v1::RecordSessionResponse>> reader;
};

class RecordTest : public ::testing::Test {
 protected:
  RecordTest() {
    const std::vector<std::byte> bytes = SmallMap();
    v1::UploadMapResponse response;
    EXPECT_TRUE(UploadMap(*server_.maps, HeaderOf(bytes), bytes, &response).ok());
    sha256_ = Sha256Of(bytes);
  }

  std::unique_ptr<TestSession> OpenSession(const std::string& vehicle_id) {
    auto session = std::make_unique<TestSession>(*server_.localization);
    v1::OpenSession open = OpenMessage();
    open.set_vehicle_id(vehicle_id);
    open.set_resumable(true);
    EXPECT_TRUE(session->Open(open));
    EXPECT_TRUE(session->Read().has_value());
    return session;
  }

  static void Close(TestSession& session) {
    v1::LocalizeRequest request;
    request.mutable_close();
    session.Send(request);
    EXPECT_TRUE(session.Finish().ok());
  }

  TestServer server_;
  std::string sha256_;
};

TEST_F(RecordTest, TheNextSessionIsTakenFromItsOpeningToItsEnd) {
  Recorder recorder(*server_.admin, "car-1");
  const auto other = OpenSession("car-2");
  ASSERT_TRUE(other->Localize(ScanMessage(0))->has_result());
  const auto session = OpenSession("car-1");
  const auto header = recorder.Read();
  ASSERT_TRUE(header.has_value() && header->has_header());
  EXPECT_EQ(header->header().open().vehicle_id(), "car-1");
  EXPECT_EQ(header->header().open().rig().radars_size(), 1);
  EXPECT_EQ(header->header().opened().map_version(), 1);
  EXPECT_EQ(header->header().map_sha256(), sha256_);
  EXPECT_TRUE(header->header().opened().resume_token().empty()) << "a secret";
  EXPECT_THAT(header->header().program(), HasSubstr("dcloc-server"));

  std::vector<v1::LocalizeResponse> answers(3);
  for (int i = 0; i < 3; ++i) {
    answers[static_cast<std::size_t>(i)] = *session->Localize(ScanMessage(i));
  }
  ASSERT_TRUE(session->Localize(ScanMessage(2))->from_memory()) << "is not recorded again";
  v1::Scan malformed;
  malformed.set_sequence_number(9);
  answers.push_back(*session->Localize(malformed));
  for (const v1::LocalizeResponse& answer : answers) {
    const auto recorded = recorder.Read();
    ASSERT_TRUE(recorded.has_value() && recorded->has_scan());
    EXPECT_EQ(recorded->scan().answer().SerializeAsString(), answer.SerializeAsString());
    if (answer.has_result()) {
      EXPECT_EQ(recorded->scan().scan().SerializeAsString(),
                ScanMessage(answer.result().sequence_number()).SerializeAsString());
    }
  }
  Close(*session);
  EXPECT_FALSE(recorder.Read().has_value());
  EXPECT_TRUE(recorder.reader->Finish().ok());
}

TEST_F(RecordTest, FixesAreInTheirPlaceAmongTheScans) {
  Recorder recorder(*server_.admin, "car-1");
  const auto session = OpenSession("car-1");
  ASSERT_TRUE(session->Localize(ScanMessage(0))->has_result());
  ASSERT_TRUE(session->Send(FixMessage(1)));
  const auto answer = session->Read();
  ASSERT_TRUE(session->Localize(ScanMessage(1))->has_result());
  Close(*session);
  ASSERT_TRUE(recorder.Read()->has_header());
  EXPECT_EQ(recorder.Read()->scan().scan().sequence_number(), 0);
  const auto recorded = recorder.Read();
  EXPECT_EQ(recorded->fix().fix().SerializeAsString(), FixMessage(1).SerializeAsString());
  EXPECT_EQ(recorded->fix().answer().SerializeAsString(),
            answer->position_fix_answer().SerializeAsString());
  EXPECT_EQ(recorder.Read()->scan().scan().sequence_number(), 1);
  EXPECT_TRUE(recorder.Finish().ok());
}

TEST_F(RecordTest, ARecorderThatKnowsNoFixesIsEndedByTheFirstOne) {
  Recorder recorder(*server_.admin, "car-1", "", /*position_fixes=*/false);
  const auto session = OpenSession("car-1");
  ASSERT_TRUE(session->Localize(ScanMessage(0))->has_result());
  ASSERT_TRUE(session->Send(FixMessage(1)));
  ASSERT_TRUE(session->Read().has_value());
  const grpc::Status status = recorder.Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_THAT(status.error_message(), HasSubstr("position fixes"));
  EXPECT_TRUE(session->Localize(ScanMessage(1))->has_result()) << "the session goes on";
}

TEST_F(RecordTest, ASessionThatIsOpenIsNotTaken) {
  const auto before = OpenSession("car-1");
  Recorder recorder(*server_.admin, "car-1");
  ASSERT_TRUE(before->Localize(ScanMessage(0))->has_result());
  Close(*before);
  const auto after = OpenSession("car-1");
  ASSERT_TRUE(after->Localize(ScanMessage(7))->has_result());
  EXPECT_TRUE(recorder.Read()->has_header());
  EXPECT_EQ(recorder.Read()->scan().scan().sequence_number(), 7);
}

TEST_F(RecordTest, EachRecorderGetsOneSession) {
  Recorder given_up(*server_.admin, "car-1");
  given_up.call.TryCancel();
  EXPECT_EQ(given_up.Finish().error_code(), grpc::StatusCode::CANCELLED);
  // Where its call is not over for the server yet, this is the session that it gets.
  Close(*OpenSession("car-1"));
  Recorder first(*server_.admin, "car-1");
  Recorder second(*server_.admin, "car-1");
  const auto one = OpenSession("car-1");
  const auto two = OpenSession("car-1");
  const auto three = OpenSession("car-1");
  EXPECT_TRUE(first.Read()->has_header());
  EXPECT_TRUE(second.Read()->has_header());
  Close(*one);
  Close(*two);
  EXPECT_TRUE(first.Finish().ok());
  EXPECT_TRUE(second.Finish().ok());
}

TEST_F(RecordTest, BadNamesAndTooManyRecordingsAreRefused) {
  Recorder nameless(*server_.admin, "two words");
  grpc::Status status = nameless.Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("vehicle_id"));
  std::vector<std::unique_ptr<Recorder>> recorders(16);
  for (auto& recorder : recorders) {
    recorder = std::make_unique<Recorder>(*server_.admin, "car-1");
  }
  Recorder beyond(*server_.admin, "car-1");
  status = beyond.Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_THAT(status.error_message(), HasSubstr("16 recordings"));
  recorders.front()->call.TryCancel();
  EXPECT_TRUE(Eventually([&] {
    Recorder again(*server_.admin, "car-2");
    again.call.TryCancel();
    return again.Finish().error_code() == grpc::StatusCode::CANCELLED;
  })) << "a place is free again";
  for (const auto& recorder : recorders) recorder->call.TryCancel();
}

TEST_F(RecordTest, OnlyOperatorsRecordAndOnlyTheirTenantsVehicles) {
  const auto identities = *OpenIdentities(server_.folder.path() / "store");
  const auto token = [&](const Principal& principal) {
    return *identities->Create(Proof::kToken, principal, {});
  };
  const std::string viewer = token({.name = "eve", .role = Role::kViewer});
  const std::string stranger = token({.name = "b", .tenant = "other", .role = Role::kOperator});
  const std::string ops = token({.name = "ops", .role = Role::kOperator});
  Recorder refused(*server_.admin, "car-1", viewer);
  const grpc::Status status = refused.Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::PERMISSION_DENIED);
  EXPECT_THAT(status.error_message(), HasSubstr("manage_sessions"));
  Recorder foreign(*server_.admin, "ops", stranger);
  Recorder own(*server_.admin, "ops", ops);

  Call call;
  call.AddMetadata("authorization", "Bearer " + ops);
  const auto stream = server_.localization->Localize(&call);
  v1::LocalizeRequest request;
  *request.mutable_open() = OpenMessage();
  request.mutable_open()->set_vehicle_id("ops");
  stream->Write(request);
  v1::LocalizeResponse response;
  ASSERT_TRUE(stream->Read(&response)) << stream->Finish().error_message();
  EXPECT_TRUE(own.Read()->has_header()) << "who asked first was of another tenant";
  call.TryCancel();
  foreign.call.TryCancel();
}

TEST_F(RecordTest, WhoReadsTooSlowlyIsToldSo) {
  Recorder recorder(*server_.admin, "car-1");
  const auto session = OpenSession("car-1");
  // Nothing is read: flow control fills up, then what may wait does.
  const v1::Scan scan = ScanMessage(0, 15'000);
  const std::size_t enough = 3 * (std::size_t{32} << 20) / scan.ByteSizeLong();
  for (std::size_t i = 0; i < enough; ++i) {
    v1::Scan next = scan;
    next.set_sequence_number(static_cast<std::int64_t>(i));
    next.set_stamp_ns(scan.stamp_ns() + static_cast<std::int64_t>(i) * 77'000'000);
    ASSERT_TRUE(session->Localize(next)->has_result()) << "the session goes on";
  }
  EXPECT_EQ(recorder.Finish().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
}

}  // namespace
}  // namespace dcloc::server
