#include "server/net/health_service.h"

#include <gmock/gmock.h>
#include <google/protobuf/wrappers.pb.h>
#include <grpcpp/impl/client_unary_call.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/server/fixtures/test_server.h"

namespace dcloc::server {
namespace {

using google::protobuf::Int32Value;
using google::protobuf::StringValue;
using ::testing::HasSubstr;

// As grpc.health.v1 numbers them.
constexpr int kServing = 1;
constexpr int kNotServing = 2;
constexpr int kServiceUnknown = 3;

/// A server with no other service.
class HealthServiceTest : public ::testing::Test {
 protected:
  HealthServiceTest() {
    grpc::EnableDefaultHealthCheckService(false);
    grpc::ServerBuilder builder;
    int port = 0;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(&service_);
    server_ = builder.BuildAndStart();
    channel_ = grpc::CreateChannel("127.0.0.1:" + std::to_string(port),
                                   grpc::InsecureChannelCredentials());
    service_.SetServing("", true);
  }
  ~HealthServiceTest() override { server_->Shutdown(std::chrono::system_clock::now()); }

  grpc::Status Check(const std::string& name, int* status) {
    Call call;
    StringValue request;
    request.set_value(name);
    Int32Value response;
    const grpc::internal::RpcMethod method("/grpc.health.v1.Health/Check",
                                           grpc::internal::RpcMethod::NORMAL_RPC);
    grpc::Status ended = grpc::internal::BlockingUnaryCall<StringValue, Int32Value>(
        channel_.get(), method, &call, request, &response);
    *status = response.value();
    return ended;
  }

  /// A call of Watch.
  struct Watch {
    Watch(grpc::ChannelInterface* channel, const std::string& name) {
      StringValue request;
      request.set_value(name);
      const grpc::internal::RpcMethod method("/grpc.health.v1.Health/Watch",
                                             grpc::internal::RpcMethod::SERVER_STREAMING);
      reader.reset(
          grpc::internal::ClientReaderFactory<Int32Value>::Create(channel, method, &call, request));
    }

    /// What it is told next; 0 at its end.
    int Next() {
      Int32Value response;
      return reader->Read(&response) ? response.value() : 0;
    }

    Call call;
    std::unique_ptr<grpc::ClientReader<Int32Value>> reader;
  };

  PeerFaultCounts faults_;
  AwaitedRequests requests_{[] {
                              return AwaitedRequests::Bounds{.count = {.total = 10},
                                                             .time = std::chrono::seconds(10)};
                            },
                            faults_};
  HealthService service_{requests_, [] { return WaitingBounds{.total = 10, .group = 2}; }};
  std::unique_ptr<grpc::Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
};

TEST_F(HealthServiceTest, CheckTellsWhatIsSetAndWhatIsNot) {
  int status = 0;
  EXPECT_TRUE(Check("", &status).ok());
  EXPECT_EQ(status, kServing);
  service_.SetServing("", false);
  EXPECT_TRUE(Check("", &status).ok());
  EXPECT_EQ(status, kNotServing);
  EXPECT_EQ(Check("nothing", &status).error_code(), grpc::StatusCode::NOT_FOUND);
  const grpc::Status refused = Check(std::string(201, 'x'), &status);
  EXPECT_EQ(refused.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(refused.error_message(), HasSubstr("201"));
}

TEST_F(HealthServiceTest, WatchTellsEachChange) {
  Watch server(channel_.get(), "");
  EXPECT_EQ(server.Next(), kServing);
  Watch other(channel_.get(), "maps");
  EXPECT_EQ(other.Next(), kServiceUnknown);
  service_.SetServing("", false);
  EXPECT_EQ(server.Next(), kNotServing);
  service_.SetServing("maps", true);
  EXPECT_EQ(other.Next(), kServing);
}

TEST_F(HealthServiceTest, WhoWatchesIsBoundedAndTheOldestGoes) {
  std::vector<std::unique_ptr<Watch>> watches;
  for (int i = 0; i < 3; ++i) {
    watches.push_back(std::make_unique<Watch>(channel_.get(), ""));
    EXPECT_EQ(watches.back()->Next(), kServing);
  }
  EXPECT_EQ(watches.front()->Next(), 0);
  const grpc::Status ended = watches.front()->reader->Finish();
  EXPECT_EQ(ended.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_THAT(ended.error_message(), HasSubstr("watch health"));
  EXPECT_EQ(service_.watcher_count(), 2);
  watches.clear();  // the last two are cancelled
}

TEST_F(HealthServiceTest, AShutdownEndsThem) {
  Watch watch(channel_.get(), "");
  EXPECT_EQ(watch.Next(), kServing);
  service_.Shutdown();
  EXPECT_EQ(watch.Next(), 0);
  EXPECT_EQ(watch.reader->Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
  int status = 0;
  EXPECT_TRUE(Check("", &status).ok());
  EXPECT_EQ(status, kNotServing);
  EXPECT_TRUE(Eventually([&] { return service_.watcher_count() == 0; }));
}

TEST_F(HealthServiceTest, WhoGoesIsForgotten) {
  {
    Watch watch(channel_.get(), "");
    EXPECT_EQ(watch.Next(), kServing);
    EXPECT_EQ(service_.watcher_count(), 1);
    watch.call.TryCancel();
  }
  EXPECT_TRUE(Eventually([&] { return service_.watcher_count() == 0; }));
}

}  // namespace
}  // namespace dcloc::server
