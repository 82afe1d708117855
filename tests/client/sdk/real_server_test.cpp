#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "client/sdk/channel.h"
#include "client/sdk/map_client.h"
#include "client/sdk/session.h"
#include "server/app/server.h"
#include "server/app/storage.h"
#include "tests/client/sdk/certificates.h"
#include "tests/core/map/synthetic_map.h"
#include "tests/core/map/temporary_folder.h"

namespace dcloc::client {
namespace {

using ::testing::HasSubstr;

/// The SDK against the server as it is shipped, with its matcher that only integrates.
class RealServerTest : public ::testing::Test {
 protected:
  void Start(server::ServerConfig config = {}) {
    config.data = (folder_.path() / "data").string();
    config.listen = "localhost:0";
    config.stub_localizer = true;
    auto server = server::Server::Start(config);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }

  std::shared_ptr<grpc::Channel> Channel(ChannelOptions options = {}) const {
    options.server = server_->address();
    auto channel = MakeChannel(options);
    EXPECT_TRUE(channel.ok()) << channel.status();
    return *std::move(channel);
  }

  std::filesystem::path MapFile(std::size_t keyframe_count) const {
    return folder_.Write(std::to_string(keyframe_count) + ".map",
                         SyntheticMap(keyframe_count, 300).Bytes());
  }

  absl::StatusOr<std::unique_ptr<Session>> OpenSession(
      const ChannelOptions& options = {}, const SessionOptions& session_options = {}) const {
    v1::OpenSession open;
    open.set_vehicle_id("car");
    open.set_map_name("town");
    v1::RadarModel& radar = *open.mutable_rig()->add_radars();
    radar.set_radar_id("front");
    radar.mutable_t_vehicle_radar()->mutable_translation_m()->set_x(3.5);
    radar.mutable_t_vehicle_radar()->mutable_rotation()->set_w(1.0);
    v1::PoseWithCovariance& pose = *open.mutable_initial_pose();
    pose.mutable_pose()->mutable_translation_m()->set_x(5e5);
    pose.mutable_pose()->mutable_rotation()->set_w(1.0);
    for (int i = 0; i < 36; ++i) pose.add_covariance(i % 7 == 0 ? 0.01 : 0.0);
    return Session::Open(Channel(options), open, session_options);
  }

  const TemporaryFolder folder_;
  std::unique_ptr<server::Server> server_;
};

TEST_F(RealServerTest, MapsAreUploadedListedActivatedAndDeleted) {
  Start();
  MapClient maps(Channel());
  EXPECT_TRUE(maps.List()->empty());

  std::vector<std::pair<std::int64_t, std::int64_t>> progress;
  const auto first =
      maps.Upload(MapFile(100), "town",
                  {.activate = true, .progress = [&](std::int64_t sent, std::int64_t size) {
                     progress.emplace_back(sent, size);
                   }});
  ASSERT_TRUE(first.ok()) << first.status();
  EXPECT_EQ(first->version(), 1);
  EXPECT_TRUE(first->active());
  EXPECT_EQ(first->info().keyframe_count(), 100);
  EXPECT_GT(progress.size(), 2U);
  EXPECT_EQ(progress.back(), std::pair(first->size_bytes(), first->size_bytes()));

  const auto second = maps.Upload(MapFile(120), "town", {});
  ASSERT_TRUE(second.ok()) << second.status();
  EXPECT_EQ(maps.ListVersions("town")->size(), 2U);
  EXPECT_EQ(maps.Get("town")->active_version(), 1);
  EXPECT_EQ(maps.Activate("town", 2)->active_version(), 2);
  EXPECT_EQ(maps.GetVersion("town", 0)->version(), 2);
  EXPECT_EQ(maps.DeleteVersion("town", 2).code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_TRUE(maps.DeleteVersion("town", 1).ok());
  EXPECT_EQ(maps.ListVersions("town")->size(), 1U);
  EXPECT_EQ(maps.List()->front().name(), "town");
  EXPECT_TRUE(maps.Delete("town").ok());
  EXPECT_TRUE(maps.List()->empty());
  EXPECT_EQ(maps.Get("town").status().code(), absl::StatusCode::kNotFound);
}

TEST_F(RealServerTest, ListsGoOnToTheLastPage) {
  Start();
  MapClient maps(Channel());
  const std::filesystem::path file = MapFile(1);
  constexpr std::size_t kMaps = 130;  // more than a page of 100
  for (std::size_t i = 0; i < kMaps; ++i) {
    ASSERT_TRUE(maps.Upload(file, "map-" + std::to_string(i), {}).ok());
  }
  EXPECT_EQ(maps.List()->size(), kMaps);
}

TEST_F(RealServerTest, BadUploadsAreClearErrors) {
  Start();
  MapClient maps(Channel());
  const auto missing =
      maps.Upload(folder_.path() / "missing.map", "town", {.activate = true}).status();
  EXPECT_EQ(missing.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(missing.message()), HasSubstr("missing.map"));

  const auto no_file = maps.Upload(folder_.path(), "town", {.activate = true}).status();
  EXPECT_FALSE(no_file.ok());
  EXPECT_THAT(std::string(no_file.message()), HasSubstr(folder_.path().string()));

  std::vector<std::byte> bytes = SyntheticMap(100, 300).Bytes();
  bytes[bytes.size() / 2] ^= std::byte{1};
  const auto broken =
      maps.Upload(folder_.Write("broken.map", bytes), "town", {.activate = true}).status();
  EXPECT_EQ(broken.code(), absl::StatusCode::kDataLoss) << broken;
  EXPECT_EQ(maps.Upload(MapFile(1), "No Such Name!", {.activate = true}).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(maps.Upload(folder_.Write("empty.map", {}), "town", {.activate = true}).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_TRUE(maps.List()->empty());
}

TEST_F(RealServerTest, AServerThatIsGoneIsUnavailable) {
  Start();
  MapClient maps(Channel());
  const std::filesystem::path file = MapFile(10);
  server_.reset();
  EXPECT_EQ(maps.List().status().code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(maps.Upload(file, "town", {.activate = true}).status().code(),
            absl::StatusCode::kUnavailable);
}

TEST_F(RealServerTest, ASessionIsAnsweredAndWithoutReconnectEndsWhenTheServerStops) {
  Start();
  ASSERT_TRUE(MapClient(Channel()).Upload(MapFile(100), "town", {.activate = true}).ok());
  const auto session = OpenSession({}, {.reconnect = std::nullopt});
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_EQ((*session)->opened().map_version(), 1);
  for (int i = 0; i < 5; ++i) {
    v1::Scan scan;
    scan.set_sequence_number(i);
    scan.set_radar_id(i == 3 ? "unknown" : "front");
    scan.set_stamp_ns(1'000'000'000 + i * 77'000'000);
    ASSERT_TRUE((*session)->Send(scan).ok());
    const auto answer = (*session)->Next();
    ASSERT_TRUE(answer.has_value());
    EXPECT_EQ(answer->has_rejected(), i == 3) << answer->ShortDebugString();
  }
  server_->Shutdown(std::chrono::seconds(2));
  EXPECT_FALSE((*session)->Next().has_value());
  EXPECT_EQ((*session)->EndStatus().code(), absl::StatusCode::kUnavailable);
}

TEST_F(RealServerTest, MutualTlsLetsInWhoHasACertificateAndNobodyElse) {
  const Certificates files = MakeCertificates(folder_.path());
  Start({.tls_cert = files.server_cert, .tls_key = files.server_key, .tls_client_ca = files.ca});
  const ChannelOptions with_certificate{.tls_ca = files.ca,
                                        .tls_cert = files.client_cert,
                                        .tls_key = files.client_key,
                                        .tls_server_name = "localhost"};
  MapClient maps(Channel(with_certificate));
  const auto uploaded = maps.Upload(MapFile(10), "town", {.activate = true});
  ASSERT_TRUE(uploaded.ok()) << uploaded.status();
  const auto session = OpenSession(with_certificate);
  EXPECT_TRUE(session.ok()) << session.status();

  EXPECT_EQ(MapClient(Channel()).List().status().code(), absl::StatusCode::kUnavailable);
  const ChannelOptions without_certificate{.tls_ca = files.ca, .tls_server_name = "localhost"};
  EXPECT_EQ(MapClient(Channel(without_certificate)).List().status().code(),
            absl::StatusCode::kUnavailable);
  const Certificates others = MakeCertificates([&] {
    std::filesystem::create_directory(folder_.path() / "others");
    return folder_.path() / "others";
  }());
  const ChannelOptions another_authority{.tls_ca = others.ca, .tls_server_name = "localhost"};
  EXPECT_EQ(MapClient(Channel(another_authority)).List().status().code(),
            absl::StatusCode::kUnavailable);
}

TEST_F(RealServerTest, ATokenSaysWhoCalls) {
  const Certificates files = MakeCertificates(folder_.path());
  Start({.tls_cert = files.server_cert, .tls_key = files.server_key});
  ChannelOptions options{.tls_ca = files.ca, .tls_server_name = "localhost"};
  const auto identities = *server::OpenIdentities(folder_.path() / "data");
  const auto token_file = [&](const std::string& name, server::Role role) {
    const std::string token =
        *identities->Create(server::Proof::kToken, {.name = name, .role = role}, {}) + "\n";
    return folder_.Write(name, std::as_bytes(std::span(token))).string();
  };
  const std::string ops = token_file("ops", server::Role::kOperator);
  const std::string car = token_file("car", server::Role::kVehicle);

  EXPECT_EQ(MapClient(Channel(options)).List().status().code(), absl::StatusCode::kUnauthenticated);
  options.token_file = ops;
  ASSERT_TRUE(MapClient(Channel(options)).Upload(MapFile(10), "town", {.activate = true}).ok());
  options.token_file = car;
  EXPECT_EQ(MapClient(Channel(options)).List().status().code(),
            absl::StatusCode::kPermissionDenied);
  const auto session = OpenSession(options);
  ASSERT_TRUE(session.ok()) << session.status();
  v1::Scan scan;
  scan.set_radar_id("front");
  scan.set_stamp_ns(1'000'000'000);
  ASSERT_TRUE((*session)->Send(scan).ok());
  EXPECT_TRUE((*session)->Next()->has_result());
}

TEST_F(RealServerTest, OnLoopbackATokenNeedsNoTls) {
  Start({.require_identity = true});
  const auto identities = *server::OpenIdentities(folder_.path() / "data");
  const std::string token = *identities->Create(server::Proof::kToken, {.name = "ops"}, {});
  const std::string file = folder_.Write("token", std::as_bytes(std::span(token))).string();
  EXPECT_TRUE(MapClient(Channel({.token_file = file})).List().ok());
  EXPECT_EQ(MapClient(Channel()).List().status().code(), absl::StatusCode::kUnauthenticated);
}

TEST_F(RealServerTest, WhoMayManageTheServerWorksInATenant) {
  Start({});
  ASSERT_TRUE(MapClient(Channel({.tenant = "acme"})).Upload(MapFile(10), "town", {}).ok());
  EXPECT_EQ(MapClient(Channel({.tenant = "acme"})).List()->size(), 1U);
  EXPECT_EQ(MapClient(Channel()).List()->size(), 0U);
}

TEST(ChannelTest, ATenantThatNoHeaderCanHoldIsRefused) {
  for (const char* tenant : {"a/b", "Acme", "a\nb", "\xff"}) {
    const absl::Status status = MakeChannel({.server = "localhost:1", .tenant = tenant}).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << tenant;
    EXPECT_THAT(std::string(status.message()), HasSubstr("tenant is"));
  }
}

TEST(ChannelTest, ATokenIsNotSentInPlaintextToAnotherMachine) {
  const TemporaryFolder folder;
  const std::string text = "secret\n";
  const std::string file = folder.Write("token", std::as_bytes(std::span(text))).string();
  for (const char* server : {"192.0.2.1:1", "[2001:db8::1]:1", "maps.example:1", "128.0.0.1:1",
                             "localhost.example:1", "127.0.0.1.example:1"}) {
    const absl::Status status = MakeChannel({.server = server, .token_file = file}).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << server;
    EXPECT_THAT(std::string(status.message()), HasSubstr("plaintext"));
  }
  for (const char* server : {"localhost:1", "127.0.0.1:1", "127.1.2.3:1", "[::1]:1"}) {
    EXPECT_TRUE(MakeChannel({.server = server, .token_file = file}).ok()) << server;
  }
}

TEST(ChannelTest, ATokenFileHoldsOneWord) {
  const TemporaryFolder folder;
  const auto status_of = [&](const std::string& text) {
    const std::string file = folder.Write("token", std::as_bytes(std::span(text))).string();
    return MakeChannel({.server = "localhost:1", .token_file = file}).status();
  };
  EXPECT_TRUE(status_of("dcloc_1\r\n").ok());
  for (const std::string& text :
       {std::string(), std::string("\n"), std::string("two words"), std::string("a\nb: c"),
        std::string("\x7f"), std::string(5000, 'x')}) {
    const absl::Status status = status_of(text);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << text;
    EXPECT_THAT(std::string(status.message()), HasSubstr("token_file: "));
  }
  EXPECT_EQ(
      MakeChannel({.server = "localhost:1", .token_file = "/nonexistent/token"}).status().code(),
      absl::StatusCode::kNotFound);
}

TEST(ChannelTest, OptionsErrorsNameTheOption) {
  for (const char* server : {"", "host", "host:", ":50051", "host:0", "host:70000", "host:5x"}) {
    const absl::Status status = MakeChannel({.server = server}).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << server;
    EXPECT_THAT(std::string(status.message()), HasSubstr("HOST:PORT"));
  }
  EXPECT_TRUE(MakeChannel({.server = "[::1]:50051"}).ok());
  EXPECT_THAT(std::string(MakeChannel({.server = "a:1", .tls_cert = "x"}).status().message()),
              HasSubstr("tls_key"));
  EXPECT_THAT(
      std::string(
          MakeChannel({.server = "a:1", .tls_cert = "x", .tls_key = "y"}).status().message()),
      HasSubstr("tls_ca"));
  const TemporaryFolder folder;
  const std::string missing = (folder.path() / "missing.pem").string();
  const absl::Status status = MakeChannel({.server = "a:1", .tls_ca = missing}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(status.message()), HasSubstr(missing));
  const std::string no_pem = folder.Write("no.pem", std::vector<std::byte>(20)).string();
  EXPECT_THAT(std::string(MakeChannel({.server = "a:1", .tls_ca = no_pem}).status().message()),
              HasSubstr("no PEM"));
}

}  // namespace
}  // namespace dcloc::client
