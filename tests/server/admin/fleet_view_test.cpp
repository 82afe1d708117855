#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "server/identity/postgres_identity_store.h"
#include "server/postgres/postgres_database.h"
#include "tests/server/admin/fleet.h"

// Servers on one database, each of which answers operators for all.
namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

using FleetViewTest = FleetTest;

TEST_F(FleetViewTest, EachListsTheSessionsOfAllAndSaysWhereTheyAre) {
  const auto at_a = Drive(*a_, "car-a");
  const auto at_b = Drive(*b_, "car-b");
  for (const TestServer* asked : {a_.get(), b_.get()}) {
    std::set<std::pair<std::string, std::string>> seen;
    const v1::ListSessionsResponse list = List(*asked);
    for (const v1::Session& session : list.sessions()) {
      seen.emplace(session.vehicle_id(), session.replica());
    }
    EXPECT_EQ(list.unanswered_size(), 0);
    EXPECT_EQ(seen, (std::set<std::pair<std::string, std::string>>{
                        {"car-a", a_->server->address()}, {"car-b", b_->server->address()}}));
  }
}

TEST_F(FleetViewTest, WhoAsksEachServerGetsItsOwnSessionsAlone) {
  const auto at_a = Drive(*a_, "car-a");
  const auto at_b = Drive(*b_, "car-b");
  Call call;
  v1::ListSessionsRequest request;
  request.set_this_replica_only(true);
  v1::ListSessionsResponse list;
  ASSERT_TRUE(b_->admin->ListSessions(&call, request, &list).ok());
  ASSERT_EQ(list.sessions_size(), 1);
  EXPECT_EQ(list.sessions(0).vehicle_id(), "car-b");
}

TEST_F(FleetViewTest, ATenantIsEnteredAtAllOfThem) {
  const auto at_b = Drive(*b_, "car-b");
  Call call;
  call.AddMetadata("dcloc-tenant", "acme");
  v1::ListSessionsResponse list;
  ASSERT_TRUE(a_->admin->ListSessions(&call, {}, &list).ok());
  EXPECT_EQ(list.sessions_size(), 0) << "it is of the default tenant";
  EXPECT_EQ(list.unanswered_size(), 0);
}

TEST_F(FleetViewTest, PagesHaveEachSessionOnce) {
  std::vector<std::unique_ptr<TestSession>> sessions;
  sessions.reserve(9);
  for (int i = 0; i < 9; ++i) {
    sessions.push_back(Drive(i % 3 == 0 ? *a_ : *b_, "car-" + std::to_string(i)));
  }
  std::vector<std::string> ids;
  std::string page_token;
  do {
    const v1::ListSessionsResponse page = List(*a_, 2, page_token);
    EXPECT_LE(page.sessions_size(), 2);
    for (const v1::Session& session : page.sessions()) ids.push_back(session.session_id());
    page_token = page.next_page_token();
  } while (!page_token.empty());
  EXPECT_EQ(ids.size(), 9U);
  EXPECT_TRUE(std::ranges::is_sorted(ids));
  EXPECT_EQ(std::set(ids.begin(), ids.end()).size(), 9U);
}

TEST_F(FleetViewTest, ASessionIsFoundAndEndedWhereverItIs) {
  const auto session = Drive(*b_, "car-b");
  v1::GetSessionRequest get;
  get.set_session_id(SessionOf(*a_, "car-b"));
  v1::GetSessionResponse got;
  Call first;
  ASSERT_TRUE(a_->admin->GetSession(&first, get, &got).ok());
  EXPECT_EQ(got.session().replica(), b_->server->address());
  v1::EndSessionRequest end;
  end.set_session_id(get.session_id());
  v1::EndSessionResponse ended;
  Call second;
  ASSERT_TRUE(a_->admin->EndSession(&second, end, &ended).ok());
  EXPECT_EQ(session->Finish().error_code(), grpc::StatusCode::ABORTED);
  get.set_session_id("nobody's");
  Call third;
  EXPECT_EQ(a_->admin->GetSession(&third, get, &got).error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(FleetViewTest, ASessionIsWatchedFromAnotherReplica) {
  const auto session = Drive(*b_, "car-b");
  v1::WatchSessionRequest request;
  request.set_session_id(SessionOf(*a_, "car-b"));
  request.set_scans(true);
  Call call;
  const auto reader = a_->admin->WatchSession(&call, request);
  reader->WaitForInitialMetadata();
  v1::WatchSessionResponse response;
  std::int64_t number = 0;
  std::thread driving([&] {
    for (number = 1; number < 500; ++number) {
      if (!session->Localize(ScanMessage(number))) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  });
  ASSERT_TRUE(reader->Read(&response));
  std::int64_t last = response.answer().result().sequence_number();
  EXPECT_EQ(response.rig().radars_size(), OpenMessage().rig().radars_size());
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE(reader->Read(&response));
    EXPECT_EQ(response.answer().result().sequence_number(), ++last);
    EXPECT_EQ(response.scan().sequence_number(), last);
    EXPECT_GT(response.scan().range_m_size(), 0);
    EXPECT_FALSE(response.has_rig()) << "it comes once";
  }
  driving.join();
  session->CloseSending();
  while (reader->Read(&response)) {
  }
  EXPECT_TRUE(reader->Finish().ok()) << "the session has ended";
  EXPECT_TRUE(session->Finish().ok());
}

TEST_F(FleetViewTest, ARecordingIsMadeWhereverTheVehicleOpens) {
  for (TestServer* driven : {b_.get(), a_.get()}) {
    v1::RecordSessionRequest request;
    request.set_vehicle_id("car-1");
    Call call;
    const auto reader = a_->admin->RecordSession(&call, request);
    reader->WaitForInitialMetadata();
    const auto session = Drive(*driven, "car-1");
    ASSERT_TRUE(session->Localize(ScanMessage(1)));
    v1::RecordSessionResponse message;
    ASSERT_TRUE(reader->Read(&message)) << reader->Finish().error_message();
    EXPECT_EQ(message.header().open().vehicle_id(), "car-1");
    ASSERT_TRUE(reader->Read(&message));
    EXPECT_EQ(message.scan().scan().sequence_number(), 1);
    // Only one is recorded.
    const auto other = Drive(driven == a_.get() ? *b_ : *a_, "car-1");
    ASSERT_TRUE(other->Localize(ScanMessage(7)));
    ASSERT_TRUE(session->Localize(ScanMessage(2)));
    ASSERT_TRUE(reader->Read(&message));
    EXPECT_EQ(message.scan().scan().sequence_number(), 2);
    session->CloseSending();
    EXPECT_TRUE(session->Finish().ok());
    EXPECT_FALSE(reader->Read(&message));
    EXPECT_TRUE(reader->Finish().ok());
  }
}

TEST_F(FleetViewTest, OneIsDrainedAndAskedThroughAnother) {
  v1::DrainRequest drain;
  drain.set_replica(b_->server->address());
  v1::DrainResponse drained;
  Call first;
  ASSERT_TRUE(a_->admin->Drain(&first, drain, &drained).ok());
  EXPECT_EQ(drained.replica(), b_->server->address());
  v1::GetServerStateRequest request;
  for (const auto& [replica, draining] :
       {std::pair(a_->server->address(), false), std::pair(b_->server->address(), true)}) {
    request.set_replica(replica);
    v1::GetServerStateResponse state;
    Call call;
    ASSERT_TRUE(a_->admin->GetServerState(&call, request, &state).ok());
    EXPECT_EQ(state.replica(), replica);
    EXPECT_EQ(state.draining(), draining);
  }
  request.set_replica("nowhere:1");
  v1::GetServerStateResponse state;
  Call call;
  const grpc::Status status = a_->admin->GetServerState(&call, request, &state);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_THAT(status.error_message(), HasSubstr(b_->server->address()));
}

TEST_F(FleetViewTest, ACallIsHandedOnWithTheCallersRights) {
  const auto store = *PostgresIdentityStore::Open(*PostgresDatabase::Open({.address = database_}));
  const std::string north = *store->Create(Proof::kToken, {.name = "n", .tenant = "north"}, {});
  const std::string admin = *store->Create(Proof::kToken, {.name = "admin"}, {});
  std::this_thread::sleep_for(std::chrono::seconds(1));  // until it holds everywhere
  const auto session = Drive(*b_, "car-b", admin);
  EXPECT_EQ(List(*a_, 0, "", admin).sessions_size(), 1);
  const v1::ListSessionsResponse list = List(*a_, 0, "", north);
  EXPECT_EQ(list.sessions_size(), 0) << "it is another tenant's";
  EXPECT_EQ(list.unanswered_size(), 0);
  EXPECT_EQ(ReplicaCount(*a_, "dct_wrong"), -1);
}

TEST_F(FleetViewTest, ACallThatWasHandedOnGoesNoFurther) {
  const auto session = Drive(*b_, "car-b");
  Call call;
  call.AddMetadata("x-dcloc-handed-on-by", "somebody");
  v1::ListSessionsResponse response;
  ASSERT_TRUE(a_->admin->ListSessions(&call, {}, &response).ok());
  EXPECT_EQ(response.sessions_size(), 0);
}

TEST_F(FleetViewTest, OneThatIsGoneIsNamedUntilItsLeaseEnds) {
  PostgresPool pool({.address = database_});
  ASSERT_TRUE(pool.WithConnection([](PostgresConnection& connection) {
                    return connection
                        .Query(
                            "INSERT INTO replica VALUES ('127.0.0.1:1',"
                            " clock_timestamp() + interval '8 s')")
                        .status();
                  })
                  .ok());
  const auto session = Drive(*a_, "car-a");
  v1::ListSessionsResponse list;
  ASSERT_TRUE(Eventually([&] { return (list = List(*a_)).unanswered_size() == 1; }));
  EXPECT_EQ(list.sessions_size(), 1);
  EXPECT_EQ(list.unanswered(0).address(), "127.0.0.1:1");
  EXPECT_THAT(list.unanswered(0).fault(), HasSubstr("connect"));
}

TEST_F(FleetViewTest, OneThatStopsIsNoReplicaAnyMore) {
  b_.reset();
  EXPECT_TRUE(Eventually([this] {
    Call call;
    v1::ListReplicasResponse response;
    a_->admin->ListReplicas(&call, {}, &response);
    return response.replicas_size() == 1;
  }));
}

TEST(ServerByItselfTest, IsItsOnlyReplica) {
  const TestServer server;
  Call call;
  v1::ListReplicasResponse response;
  ASSERT_TRUE(server.admin->ListReplicas(&call, {}, &response).ok());
  ASSERT_EQ(response.replicas_size(), 1);
  EXPECT_EQ(response.replicas(0).address(), "");
  EXPECT_TRUE(response.replicas(0).has_state());
}

}  // namespace
}  // namespace dcloc::server
