#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/server/localization/session_fixture.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

/// The stub localizer contradicts each fix: what is tested here is the path of a proposal to the
/// session.
class ProposePoseTest : public SessionFixture {
 protected:
  grpc::Status Propose(const v1::ProposePoseRequest& request, v1::ProposePoseResponse* response) {
    Call call;
    return server_.admin->ProposePose(&call, request, response);
  }

  static v1::ProposePoseRequest RequestOf(const std::string& session_id) {
    v1::ProposePoseRequest request;
    request.set_session_id(session_id);
    *request.mutable_pose() = FixMessage(0).map_pose();
    return request;
  }
};

TEST_F(ProposePoseTest, IsWeighedAtTheLastScanAndTheVehicleIsNotTold) {
  const auto session = Connect();
  const std::string id = Open(*session, OpenMessage()).session_id();
  ASSERT_TRUE(session->Localize(ScanMessage(3))->has_result());
  v1::ProposePoseResponse response;
  ASSERT_TRUE(Propose(RequestOf(id), &response).ok());
  EXPECT_EQ(response.answer().stamp_ns(), ScanMessage(3).stamp_ns());
  EXPECT_EQ(response.answer().use(), v1::FIX_USE_CONTRADICTED) << "by the stub";
  EXPECT_EQ(Get(id).position_fix_count(), 1);
  EXPECT_TRUE(session->Localize(ScanMessage(4))->has_result()) << "the next answer is the scan's";
}

TEST_F(ProposePoseTest, MayHaveAStampOfItsOwn) {
  const auto session = Connect();
  const std::string id = Open(*session, OpenMessage()).session_id();
  ASSERT_TRUE(session->Localize(ScanMessage(3))->has_result());
  v1::ProposePoseRequest request = RequestOf(id);
  request.set_stamp_ns(ScanMessage(2).stamp_ns());
  v1::ProposePoseResponse response;
  ASSERT_TRUE(Propose(request, &response).ok());
  EXPECT_EQ(response.answer().stamp_ns(), ScanMessage(2).stamp_ns());
}

TEST_F(ProposePoseTest, ErrorsNameWhatIsWrong) {
  const auto session = Connect();
  const std::string id = Open(*session, OpenMessage()).session_id();
  v1::ProposePoseResponse response;
  EXPECT_EQ(Propose(RequestOf("nobody"), &response).error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(Propose(RequestOf(id), &response).error_code(), grpc::StatusCode::FAILED_PRECONDITION)
      << "no scan has told the vehicle's clock";
  ASSERT_TRUE(session->Localize(ScanMessage(0))->has_result());
  v1::ProposePoseRequest without;
  without.set_session_id(id);
  EXPECT_THAT(Propose(without, &response).error_message(), HasSubstr("pose is missing"));
  v1::ProposePoseRequest endless = RequestOf(id);
  endless.mutable_pose()->set_covariance(0, std::numeric_limits<double>::infinity());
  const grpc::Status status = Propose(endless, &response);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("pose.covariance[0]"));
  EXPECT_TRUE(session->Localize(ScanMessage(1))->has_result());
}

}  // namespace
}  // namespace dcloc::server
