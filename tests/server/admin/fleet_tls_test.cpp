#include <gmock/gmock.h>
#include <grpcpp/create_channel.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "server/identity/postgres_identity_store.h"
#include "server/postgres/postgres_database.h"
#include "tests/server/fixtures/postgres_cluster.h"
#include "tests/server/fixtures/test_certificates.h"
#include "tests/server/fixtures/test_server.h"

// Servers that reach each other by TLS, and by TLS with certificates on both sides.
namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

class FleetTlsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    DCLOC_SKIP_WITHOUT_POSTGRES();
    database_ = PostgresCluster::Get().NewDatabase();
    authority_.Write(folder_.path(), "authority");
    TestCertificate::Authority("someone else").Write(folder_.path(), "stranger");
    TestCertificate::SignedBy(authority_, "replica").Write(folder_.path(), "replica");
    const auto store =
        *PostgresIdentityStore::Open(*PostgresDatabase::Open({.address = database_}));
    token_ = *store->Create(Proof::kToken, {.name = "ops"}, {});
    ASSERT_TRUE(store->Create(Proof::kCertificate, {.name = "operator"}, {}).ok());
  }

  std::string Path(const std::string& name) const { return folder_.path() / name; }

  ServerConfig TlsConfig() const {
    ServerConfig config = TestServer::StubConfig();
    config.catalogue = database_;
    config.map_folder = folder_.path() / "shared";
    config.tls_cert = Path("replica.pem");
    config.tls_key = Path("replica.key");
    config.replica_address = "127.0.0.1";
    config.replica_ca = Path("authority.pem");
    return config;
  }

  ServerConfig MutualConfig() const {
    ServerConfig config = TlsConfig();
    config.tls_client_ca = Path("authority.pem");
    config.replica_cert = Path("replica.pem");
    config.replica_key = Path("replica.key");
    return config;
  }

  /// What `server` says of all, to who shows `certificate` and `token`; either may be empty.
  v1::ListReplicasResponse AskAll(const TestServer& server, const std::string& certificate,
                                  const std::string& token) const {
    grpc::SslCredentialsOptions options;
    options.pem_root_certs = authority_.CertificatePem();
    if (!certificate.empty()) {
      const TestCertificate shown = TestCertificate::SignedBy(authority_, certificate);
      options.pem_cert_chain = shown.CertificatePem();
      options.pem_private_key = shown.KeyPem();
    }
    const auto stub = v1::AdminService::NewStub(
        grpc::CreateChannel(server.server->address(), grpc::SslCredentials(options)));
    CallAs call(token);
    v1::ListReplicasResponse response;
    const grpc::Status status = stub->ListReplicas(&call, {}, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response;
  }

  static int AnsweredCount(const v1::ListReplicasResponse& response) {
    int count = 0;
    for (const v1::Replica& replica : response.replicas()) count += replica.has_state() ? 1 : 0;
    return count;
  }

  /// The first replica's fault; empty if there is none.
  static std::string FaultOf(const v1::ListReplicasResponse& response) {
    for (const v1::Replica& replica : response.replicas()) {
      if (!replica.fault().empty()) return replica.fault();
    }
    return "";
  }

  TemporaryFolder folder_;
  const TestCertificate authority_ = TestCertificate::Authority("fleet authority");
  std::string database_;
  std::string token_;
};

TEST_F(FleetTlsTest, ByTlsEachAnswersForAll) {
  const TestServer a(TlsConfig());
  const TestServer b(TlsConfig());
  EXPECT_TRUE(Eventually([&] { return AnsweredCount(AskAll(a, "", token_)) == 2; }));
  EXPECT_TRUE(Eventually([&] { return AnsweredCount(AskAll(b, "", token_)) == 2; }));
}

TEST_F(FleetTlsTest, ByMutualTlsEachAnswersForAll) {
  const TestServer a(MutualConfig());
  const TestServer b(MutualConfig());
  EXPECT_TRUE(Eventually([&] { return AnsweredCount(AskAll(a, "console", token_)) == 2; }));
}

TEST_F(FleetTlsTest, WhoHasACertificateAloneIsNotHandedOn) {
  const TestServer a(MutualConfig());
  const TestServer b(MutualConfig());
  v1::ListReplicasResponse response;
  EXPECT_TRUE(Eventually([&] {
    response = AskAll(a, "operator", "");
    return response.replicas_size() == 2;
  }));
  EXPECT_EQ(AnsweredCount(response), 1);
  EXPECT_THAT(FaultOf(response), HasSubstr("certificate cannot be handed on"));
}

TEST_F(FleetTlsTest, AServerOfAnotherAuthorityIsNotSpokenTo) {
  ServerConfig config = TlsConfig();
  config.replica_ca = Path("stranger.pem");
  const TestServer suspicious(config);
  const TestServer other(TlsConfig());
  v1::ListReplicasResponse response;
  EXPECT_TRUE(Eventually([&] {
    response = AskAll(suspicious, "", token_);
    return response.replicas_size() == 2 && !FaultOf(response).empty();
  }));
  EXPECT_EQ(AnsweredCount(response), 1) << "no token goes to a server that cannot prove itself";
}

TEST_F(FleetTlsTest, AServerThatShowsNoCertificateIsRefusedWhereOneIsNeeded) {
  ServerConfig config = MutualConfig();
  config.replica_cert = "";
  config.replica_key = "";
  const TestServer bare(config);
  const TestServer other(MutualConfig());
  v1::ListReplicasResponse response;
  EXPECT_TRUE(Eventually([&] {
    response = AskAll(bare, "console", token_);
    return response.replicas_size() == 2 && !FaultOf(response).empty();
  }));
  EXPECT_EQ(AnsweredCount(response), 1);
}

TEST_F(FleetTlsTest, NewFilesAreTakenWithoutARestart) {
  ServerConfig config = TlsConfig();
  TestCertificate::Authority("someone else").Write(folder_.path(), "changing");
  config.replica_ca = Path("changing.pem");
  const TestServer a(config);
  const TestServer b(TlsConfig());
  ASSERT_TRUE(Eventually([&] { return AskAll(a, "", token_).replicas_size() == 2; }));
  EXPECT_EQ(AnsweredCount(AskAll(a, "", token_)), 1);
  authority_.Write(folder_.path(), "changing");
  EXPECT_TRUE(Eventually([&] { return AnsweredCount(AskAll(a, "", token_)) == 2; }));
}

}  // namespace
}  // namespace dcloc::server
