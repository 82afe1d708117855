#include <gmock/gmock.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "tests/server/admin/fleet.h"

// How long a server waits for another one: what each bound is for, and that a stop waits for none.
namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using BoundsClock = std::chrono::steady_clock;

/// Takes connections and never says a word.
class SilentListener {
 public:
  SilentListener() : fd_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    EXPECT_EQ(bind(fd_, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(listen(fd_, 64), 0);
    getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
  }
  ~SilentListener() { close(fd_); }
  SilentListener(const SilentListener&) = delete;
  SilentListener& operator=(const SilentListener&) = delete;

  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

 private:
  const int fd_;
  int port_ = 0;
};

/// A replica that has every session, and searches long before it answers a proposal.
class SearchingReplica final : public v1::AdminService::Service {
 public:
  explicit SearchingReplica(std::chrono::milliseconds search) : search_(search) {
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port_);
    builder.RegisterService(this);
    server_ = builder.BuildAndStart();
  }

  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

  grpc::Status GetSession(grpc::ServerContext* /*context*/,
                          const v1::GetSessionRequest* /*request*/,
                          v1::GetSessionResponse* /*response*/) override {
    return grpc::Status::OK;
  }
  grpc::Status GetServerState(grpc::ServerContext* /*context*/,
                              const v1::GetServerStateRequest* /*request*/,
                              v1::GetServerStateResponse* /*response*/) override {
    return grpc::Status::OK;
  }
  grpc::Status ListSessions(grpc::ServerContext* /*context*/,
                            const v1::ListSessionsRequest* /*request*/,
                            v1::ListSessionsResponse* /*response*/) override {
    return grpc::Status::OK;
  }
  grpc::Status ProposePose(grpc::ServerContext* /*context*/,
                           const v1::ProposePoseRequest* /*request*/,
                           v1::ProposePoseResponse* response) override {
    std::this_thread::sleep_for(search_);
    response->mutable_answer();
    return grpc::Status::OK;
  }

 private:
  const std::chrono::milliseconds search_;
  int port_ = 0;
  std::unique_ptr<grpc::Server> server_;
};

class FleetBoundsTest : public FleetTest {
 protected:
  static double SecondsSince(BoundsClock::time_point begin) {
    return std::chrono::duration<double>(BoundsClock::now() - begin).count();
  }

  /// How long a stop of `server` takes that may take 20 s.
  static double Stop(TestServer& server) {
    const BoundsClock::time_point begin = BoundsClock::now();
    server.server->Shutdown(std::chrono::seconds(20));
    return SecondsSince(begin);
  }
};

TEST_F(FleetBoundsTest, ARecordingThatOneDoesNotTakeUpInTimeIsRefused) {
  const SilentListener silent;
  AddReplica(silent.address(), 60);
  v1::RecordSessionRequest request;
  request.set_vehicle_id("car-1");
  Call call;
  const BoundsClock::time_point begin = BoundsClock::now();
  const auto reader = a_->admin->RecordSession(&call, request);
  v1::RecordSessionResponse message;
  EXPECT_FALSE(reader->Read(&message));
  const grpc::Status status = reader->Finish();
  EXPECT_LT(SecondsSince(begin), 10.0) << "gRPC tries a connection for 20 s";
  EXPECT_EQ(status.error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_THAT(status.error_message(), AllOf(HasSubstr(silent.address()), HasSubstr("in time")));
}

TEST_F(FleetBoundsTest, AProposalMaySearchLongerThanAnAnswerMayTake) {
  const SearchingReplica searching(std::chrono::milliseconds(kReplicaTimeout_ms + 1000));
  AddReplica(searching.address(), 60);
  v1::ProposePoseRequest request;
  request.set_session_id("far away");
  *request.mutable_pose() = InitialPoseMessage();
  v1::ProposePoseResponse response;
  Call call;
  const grpc::Status status = a_->admin->ProposePose(&call, request, &response);
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_TRUE(response.has_answer());
}

TEST_F(FleetBoundsTest, AProposalFindsItsSessionAtAnotherReplica) {
  const auto session = Drive(*b_, "car-b");
  ASSERT_TRUE(session->Localize(ScanMessage(1)));
  v1::ProposePoseRequest request;
  request.set_session_id(SessionOf(*a_, "car-b"));
  *request.mutable_pose() = InitialPoseMessage();
  v1::ProposePoseResponse here;
  v1::ProposePoseResponse elsewhere;
  Call first;
  Call second;
  const grpc::Status there = b_->admin->ProposePose(&first, request, &here);
  const grpc::Status through = a_->admin->ProposePose(&second, request, &elsewhere);
  EXPECT_EQ(through.error_code(), there.error_code()) << through.error_message();
}

TEST_F(FleetBoundsTest, AStopWaitsForNoSessionThatIsWatchedElsewhere) {
  const auto session = Drive(*b_, "car-b");
  v1::WatchSessionRequest request;
  request.set_session_id(SessionOf(*a_, "car-b"));
  Call call;
  const auto reader = a_->admin->WatchSession(&call, request);
  reader->WaitForInitialMetadata();
  EXPECT_LT(Stop(*a_), 5.0);
  v1::WatchSessionResponse response;
  while (reader->Read(&response)) {
  }
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_TRUE(session->Localize(ScanMessage(1))) << "the session goes on";
}

TEST_F(FleetBoundsTest, AStopWaitsForNoVehicleThatIsToBeRecorded) {
  v1::RecordSessionRequest request;
  request.set_vehicle_id("car-1");
  Call call;
  const auto reader = a_->admin->RecordSession(&call, request);
  reader->WaitForInitialMetadata();
  EXPECT_LT(Stop(*a_), 5.0);
  v1::RecordSessionResponse message;
  EXPECT_FALSE(reader->Read(&message));
  const grpc::Status status = reader->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_THAT(status.error_message(), HasSubstr("shutting down"));
}

}  // namespace
}  // namespace dcloc::server
