#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/server/fixtures/postgres_cluster.h"
#include "tests/server/fixtures/test_maps.h"
#include "tests/server/fixtures/test_server.h"

namespace dcloc::server {

/// Two servers on one database, in this process, that know each other and have the map "town".
class FleetTest : public ::testing::Test {
 protected:
  void SetUp() override {
    DCLOC_SKIP_WITHOUT_POSTGRES();
    database_ = PostgresCluster::Get().NewDatabase();
    a_ = Start();
    b_ = Start();
    ASSERT_TRUE(Eventually([this] { return ReplicaCount(*a_) == 2 && ReplicaCount(*b_) == 2; }));
    const std::vector<std::byte> map = SmallMap();
    v1::UploadMapResponse response;
    ASSERT_TRUE(UploadMap(*a_->maps, HeaderOf(map), map, &response).ok());
  }

  std::unique_ptr<TestServer> Start() const {
    ServerConfig config = TestServer::StubConfig();
    config.replica_timeout_ms = kReplicaTimeout_ms;
    config.catalogue = database_;
    config.map_folder = folder_.path() / "shared";
    config.replica_address = "127.0.0.1";
    return std::make_unique<TestServer>(config);
  }

  /// A row of a server at `address`, which need not be one, for so many seconds. Returns once `a_`
  /// knows it.
  void AddReplica(const std::string& address, int seconds) const {
    PostgresCluster::Run(database_, "INSERT INTO dcloc.replica VALUES ('" + address +
                                        "', clock_timestamp() + interval '" +
                                        std::to_string(seconds) + " s')");
    ASSERT_TRUE(
        Eventually([this] { return List(*a_).unanswered_size() + ReplicaCount(*a_) == 3; }));
  }

  static int ReplicaCount(const TestServer& server, const std::string& token = "") {
    CallAs call(token);
    v1::ListReplicasResponse response;
    const grpc::Status status = server.admin->ListReplicas(&call, {}, &response);
    int answered = 0;
    for (const v1::Replica& replica : response.replicas()) answered += replica.has_state() ? 1 : 0;
    return status.ok() ? answered : -1;
  }

  /// A session of `vehicle`, open at `server`.
  static std::unique_ptr<TestSession> Drive(const TestServer& server, const std::string& vehicle,
                                            const std::string& token = "") {
    auto session = std::make_unique<TestSession>(*server.localization, token);
    v1::OpenSession open = OpenMessage();
    open.set_vehicle_id(vehicle);
    EXPECT_TRUE(session->Open(open));
    EXPECT_TRUE(session->Read()) << session->Finish().error_message();
    return session;
  }

  static v1::ListSessionsResponse List(const TestServer& server, int page_size = 0,
                                       const std::string& page_token = "",
                                       const std::string& token = "") {
    CallAs call(token);
    v1::ListSessionsRequest request;
    request.set_page_size(page_size);
    request.set_page_token(page_token);
    v1::ListSessionsResponse response;
    const grpc::Status status = server.admin->ListSessions(&call, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response;
  }

  static std::string SessionOf(const TestServer& server, const std::string& vehicle) {
    const v1::ListSessionsResponse list = List(server);
    for (const v1::Session& session : list.sessions()) {
      if (session.vehicle_id() == vehicle) return session.session_id();
    }
    return "";
  }

  /// Short for a test that waits for it, long for one on a busy machine that does not.
  static constexpr int kReplicaTimeout_ms = 2000;

  TemporaryFolder folder_;
  std::string database_;
  std::unique_ptr<TestServer> a_, b_;
};

}  // namespace dcloc::server
