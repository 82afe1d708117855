// Each allocation of each RPC fails in turn. The call ends with RESOURCE_EXHAUSTED, or as if
// nothing were; the server and all else live, and the next call succeeds.
#include <gmock/gmock.h>
#include <google/protobuf/dynamic_message.h>
#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <iostream>
#include <limits>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "server/identity/method_permissions.h"
#include "server/rpc/wire.h"
#include "tests/server/fixtures/raw_call.h"
#include "tests/server/fixtures/test_maps.h"
#include "tests/server/fixtures/test_server.h"
#include "tests/server/rpc/failing_allocation.h"

namespace dcloc::server {
namespace {

using ::testing::AnyOf;
using ::testing::AnyOfArray;

/// Maps "town" with two versions and "spare" with one, and a vehicle in "town".
class World {
 public:
  explicit World(bool has_vehicle = true) : server(Config()), has_vehicle_(has_vehicle) { SetUp(); }

  /// Makes what a call may have taken away.
  void SetUp() {
    ASSERT_TRUE(Eventually([this] { return !Builds(); })) << "a build does not end";
    while (CountVersions() < 2) {
      Upload("town", absl::StrCat("town ", ++count_));
      session.reset();  // it goes on in the newest version
    }
    Upload("spare", absl::StrCat("spare ", ++count_));
    upload_ = SmallMap(absl::StrCat("new ", count_));
    if (!has_vehicle_) return;
    if (session == nullptr || !session->Localize(ScanMessage(++scan_count))) OpenSession();
  }

  void OpenSession() {
    session = std::make_unique<TestSession>(*server.localization);
    v1::OpenSession open = OpenMessage();
    open.set_resumable(true);
    ASSERT_TRUE(session->Open(open));
    const std::optional<v1::LocalizeResponse> opened = session->Read();
    ASSERT_TRUE(opened);
    session_id_ = opened->opened().session_id();
  }

  /// `text` with the names of what there is.
  std::string WithNames(const char* text) const {
    return absl::StrReplaceAll(
        text, {{"$SESSION", session_id_},
               {"$SHA", Sha256Of(upload_)},
               {"$SIZE", absl::StrCat(upload_.size())},
               {"$SCAN", ScanMessage(count_).ShortDebugString()},
               {"$RIG", OpenMessage().rig().ShortDebugString()},
               {"$POSE", InitialPoseMessage().ShortDebugString()},
               {"$OLD", absl::StrCat(oldest_version_)},
               {"$BYTES",
                absl::CEscape({reinterpret_cast<const char*>(upload_.data()), upload_.size()})}});
  }

  TestServer server;
  std::unique_ptr<TestSession> session;
  std::int64_t scan_count = 0;

 private:
  static ServerConfig Config() {
    ServerConfig config;
    config.warm_map_mib = 0;
    return config;
  }

  bool Builds() {
    Call call;
    v1::ListMapBuildsResponse response;
    if (!server.maps->ListMapBuilds(&call, {}, &response).ok()) return true;
    const auto runs = [](const v1::MapBuild& build) {
      return build.state() == v1::MAP_BUILD_STATE_RUNNING;
    };
    return std::any_of(response.builds().begin(), response.builds().end(), runs);
  }

  int CountVersions() {
    Call call;
    v1::ListMapVersionsRequest request;
    request.set_map_name("town");
    v1::ListMapVersionsResponse response;
    if (!server.maps->ListMapVersions(&call, request, &response).ok()) return 0;
    oldest_version_ = std::numeric_limits<std::int64_t>::max();
    for (const v1::MapVersion& version : response.versions()) {
      oldest_version_ = std::min(oldest_version_, version.version());
    }
    return response.versions_size();
  }

  void Upload(const std::string& name, const std::string& content) {
    const std::vector<std::byte> bytes = SmallMap(content);
    v1::UploadMapHeader header = HeaderOf(bytes);
    header.set_map_name(name);
    v1::UploadMapResponse response;
    const grpc::Status status = UploadMap(*server.maps, header, bytes, &response);
    ASSERT_TRUE(status.ok()) << status.error_message();
  }

  const bool has_vehicle_;
  int count_ = 0;
  std::int64_t oldest_version_ = 0;
  std::vector<std::byte> upload_;
  std::string session_id_;
};

/// One RPC, its messages as text, and how it ends with memory, or may end.
struct Row {
  const char* method;
  std::vector<const char*> requests;
  std::vector<grpc::StatusCode> ends = {grpc::StatusCode::OK};
  bool has_vehicle = true;
};

void PrintTo(const Row& row, std::ostream* stream) { *stream << row.method; }

grpc::ByteBuffer Message(const std::string& method, const std::string& text) {
  namespace pb = google::protobuf;
  const pb::MethodDescriptor* const descriptor =
      pb::DescriptorPool::generated_pool()->FindMethodByName(method);
  const std::unique_ptr<pb::Message> message(
      pb::MessageFactory::generated_factory()->GetPrototype(descriptor->input_type())->New());
  EXPECT_TRUE(pb::TextFormat::ParseFromString(text, message.get())) << method;
  return SerializeMessage(*message);
}

grpc::Status CallOf(const World& world, const Row& row) {
  std::vector<grpc::ByteBuffer> messages;
  for (const char* text : row.requests) {
    messages.push_back(Message(row.method, world.WithNames(text)));
  }
  return EndOf(world.server, PathOf(row.method), messages);
}

/// Lets each allocation fail in turn, until `call` asks for no more.
void FailEach(World& world, const std::function<grpc::Status(World&)>& call,
              const std::vector<grpc::StatusCode>& ends = {grpc::StatusCode::OK}) {
  constexpr int kMost = 20'000;
  int skipped_count = 0;
  for (bool fails = true; fails && skipped_count < kMost; ++skipped_count) {
    world.SetUp();
    const FailingAllocation failing(skipped_count);
    const grpc::Status status = call(world);
    fails = FailingAllocation::HasFailed();
    ASSERT_THAT(status.error_code(), AnyOf(AnyOfArray(ends), grpc::StatusCode::RESOURCE_EXHAUSTED))
        << "after " << skipped_count << ": " << status.error_code() << ", "
        << status.error_message();
  }
  EXPECT_GT(skipped_count, 1) << "nothing failed";
  EXPECT_LT(skipped_count, kMost);
  world.SetUp();
  EXPECT_EQ(call(world).error_code(), ends.front());
  std::cout << skipped_count - 1 << " allocations failed\n";
}

const std::vector<Row>& Rows() {
  static const std::vector<Row> rows = {
      {"dcloc.v1.AdminService.ListReplicas", {""}},
      {"dcloc.v1.AdminService.GetServerState", {""}},
      {"dcloc.v1.AdminService.ListSessions", {""}},
      {"dcloc.v1.AdminService.GetSession", {"session_id: '$SESSION'"}},
      {"dcloc.v1.AdminService.EndSession",
       {"session_id: '$SESSION' reason: 'a test'"},
       {grpc::StatusCode::OK, grpc::StatusCode::NOT_FOUND}},  // the vehicle may end it before
      {"dcloc.v1.AdminService.ProposePose", {"session_id: '$SESSION' pose {$POSE}"}},
      {"dcloc.v1.AdminService.ListOperations", {"page_size: 2"}},
      {"dcloc.v1.AdminService.ListIdentities", {""}},
      {"dcloc.v1.AdminService.RevokeIdentity", {"id: 1"}, {grpc::StatusCode::NOT_FOUND}},
      {"dcloc.v1.MapService.ListMaps", {""}},
      {"dcloc.v1.MapService.GetMap", {"map_name: 'town'"}},
      {"dcloc.v1.MapService.ListMapVersions", {"map_name: 'town'"}},
      {"dcloc.v1.MapService.GetMapVersion", {"map_name: 'town' version: $OLD"}},
      {"dcloc.v1.MapService.UploadMap",
       {"header {map_name: 'new' size_bytes: $SIZE sha256: '$SHA' activate: true}",
        "chunk {data: '$BYTES'}"}},
      {"dcloc.v1.MapService.GetMapUpload", {"sha256: '$SHA'"}},
      {"dcloc.v1.MapService.DownloadMap", {"map_name: 'town'"}},
      {"dcloc.v1.MapService.ActivateMapVersion", {"map_name: 'town' version: $OLD"}},
      {"dcloc.v1.MapService.RollBackMap", {"map_name: 'town'"}},
      {"dcloc.v1.MapService.SetMapCanary", {"map_name: 'town' version: $OLD share: 0.5"}},
      {"dcloc.v1.MapService.FindCoverage", {"map_place {map_name: 'town'} radius_m: 100"}},
      {"dcloc.v1.MapService.ReadMapTile",
       {"map_name: 'town' min_x_m: -99 min_y_m: -99 max_x_m: 99 max_y_m: 99"}},
      {"dcloc.v1.MapService.StartMapBuild",
       {"header {map_name: 'built' drive_name: 'drive' rig {$RIG}}",
        "scan {scan {$SCAN} t_map_vehicle {translation_m {} rotation {w: 1}} begins_pass: true}"}},
      {"dcloc.v1.MapService.GetMapBuild", {"build_id: 'none'"}, {grpc::StatusCode::NOT_FOUND}},
      {"dcloc.v1.MapService.CancelMapBuild", {"build_id: 'none'"}, {grpc::StatusCode::NOT_FOUND}},
      {"dcloc.v1.MapService.ListMapBuilds", {""}},
      {"dcloc.v1.MapService.DeleteMapVersion",
       {"map_name: 'town' version: $OLD"},
       {grpc::StatusCode::OK},
       false},
      {"dcloc.v1.MapService.DeleteMap", {"map_name: 'spare'"}},
      {"dcloc.v1.PassService.SetPassConsent",
       {"consent {map_name: 'town'} state: PASS_CONSENT_STATE_GIVEN"}},
      {"dcloc.v1.PassService.ListPassConsents", {""}},
      {"dcloc.v1.PassService.ListPasses", {"map_name: 'town'"}},
  };
  return rows;
}

class OutOfMemoryTest : public ::testing::TestWithParam<Row> {};

TEST_P(OutOfMemoryTest, EachAllocationMayFail) {
  World world(GetParam().has_vehicle);
  FailEach(
      world, [](World& w) { return CallOf(w, GetParam()); }, GetParam().ends);
}

INSTANTIATE_TEST_SUITE_P(Rpcs, OutOfMemoryTest, ::testing::ValuesIn(Rows()), [](const auto& row) {
  const std::string method = row.param.method;
  return method.substr(method.rfind('.') + 1);
});

TEST(OutOfMemoryStreamTest, ASessionMayGetNone) {
  World world;
  FailEach(world, [](World& w) {
    TestSession session(*w.server.localization);
    session.Open(OpenMessage());
    for (int i = 0; i < 3; ++i) session.Send(ScanMessage(i));
    session.CloseSending();
    return session.Finish();
  });
}

/// The end of a call that sees a message, if nothing else has ended it before.
template <typename Stream, typename Response>
grpc::Status SeeOne(Call& call, Stream& stream, Response response) {
  const bool seen = stream.Read(&response);
  call.TryCancel();
  const grpc::Status status = stream.Finish();
  return seen || status.error_code() == grpc::StatusCode::CANCELLED ? grpc::Status::OK : status;
}

TEST(OutOfMemoryStreamTest, AWatcherMayGetNone) {
  World world;
  FailEach(world, [](World& w) {
    Call call;
    v1::WatchSessionRequest request;
    request.set_session_id(w.WithNames("$SESSION"));
    request.set_scans(true);
    const auto stream = w.server.admin->WatchSession(&call, request);
    stream->WaitForInitialMetadata();
    // The first one may be missed.
    for (int i = 0; i < 2; ++i) w.session->Localize(ScanMessage(++w.scan_count));
    return SeeOne(call, *stream, v1::WatchSessionResponse());
  });
}

TEST(OutOfMemoryStreamTest, ARecordingMayGetNone) {
  World world;
  FailEach(world, [](World& w) {
    Call call;
    v1::RecordSessionRequest request;
    request.set_vehicle_id("car-1");
    const auto stream = w.server.admin->RecordSession(&call, request);
    stream->WaitForInitialMetadata();
    for (int i = 0; i < 2; ++i) {  // the first one may end before it has opened
      TestSession recorded(*w.server.localization);
      recorded.Open(OpenMessage());
      if (recorded.Read()) recorded.Localize(ScanMessage(0));
    }
    return SeeOne(call, *stream, v1::RecordSessionResponse());
  });
}

TEST(OutOfMemoryTest, NoRpcIsForgotten) {
  std::set<std::string> methods = {
      "dcloc.v1.AdminService.Drain",  // ends the world that the others need; see ServerTest
      "dcloc.v1.LocalizationService.Localize", "dcloc.v1.AdminService.WatchSession",
      "dcloc.v1.AdminService.RecordSession"};
  for (const Row& row : Rows()) methods.insert(row.method);
  for (const MethodPermission& entry : MethodPermissions()) {
    EXPECT_TRUE(methods.contains(entry.method)) << entry.method;
  }
}

}  // namespace
}  // namespace dcloc::server
