#include "server/config/credentials.h"
#include "server/app/storage.h"

#include <gmock/gmock.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/security/auth_context.h>
#include <gtest/gtest.h>
#include <openssl/bio.h>
#include <openssl/ssl.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "tests/server/fixtures/test_certificates.h"
#include "tests/server/fixtures/test_server.h"

namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

/// Whether the server at `address` speaks that version of TLS, with a client that would speak any.
bool Speaks(const std::string& address, int version) {
  const std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)> context(SSL_CTX_new(TLS_client_method()),
                                                                  &SSL_CTX_free);
  SSL_CTX_set_security_level(context.get(), 0);
  SSL_CTX_set_min_proto_version(context.get(), version);
  SSL_CTX_set_max_proto_version(context.get(), version);
  constexpr unsigned char kHttp2[] = {2, 'h', '2'};
  SSL_CTX_set_alpn_protos(context.get(), kHttp2, sizeof(kHttp2));
  const std::unique_ptr<BIO, decltype(&BIO_free_all)> connection(BIO_new_ssl_connect(context.get()),
                                                                 &BIO_free_all);
  BIO_set_conn_hostname(connection.get(), address.c_str());
  return BIO_do_connect(connection.get()) == 1 && BIO_do_handshake(connection.get()) == 1;
}

class CredentialsTest : public ::testing::Test {
 protected:
  CredentialsTest()
      : authority_(TestCertificate::Authority("fleet authority")),
        stranger_(TestCertificate::Authority("someone else")) {
    authority_.Write(folder_.path(), "authority");
    TestCertificate::SignedBy(authority_, "server").Write(folder_.path(), "server");
  }

  std::string Path(const std::string& name) const { return folder_.path() / name; }

  ServerConfig TlsConfig() const {
    ServerConfig config = TestServer::StubConfig();
    config.tls_cert = Path("server.pem");
    config.tls_key = Path("server.key");
    return config;
  }

  ServerConfig MutualTlsConfig() const {
    ServerConfig config = TlsConfig();
    config.tls_client_ca = Path("authority.pem");
    return config;
  }

  /// A client that trusts the fleet's authority, and shows `certificate` if there is one.
  static std::shared_ptr<grpc::ChannelCredentials> Client(
      const TestCertificate& authority, const std::optional<TestCertificate>& certificate = {}) {
    grpc::SslCredentialsOptions options;
    options.pem_root_certs = authority.CertificatePem();
    if (certificate) {
      options.pem_cert_chain = certificate->CertificatePem();
      options.pem_private_key = certificate->KeyPem();
    }
    return grpc::SslCredentials(options);
  }

  static grpc::Status Ask(const TestServer& server,
                          const std::shared_ptr<grpc::ChannelCredentials>& credentials) {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    const auto stub = v1::AdminService::NewStub(
        grpc::CreateCustomChannel(server.server->address(), credentials, arguments));
    Call call;
    v1::GetServerStateResponse response;
    return stub->GetServerState(&call, {}, &response);
  }

  static std::string ErrorOf(const ServerConfig& config) {
    const absl::Status status = MakeCredentials(config, std::make_shared<CallGate>(0)).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
    return std::string(status.message());
  }

  TemporaryFolder folder_;
  TestCertificate authority_;
  TestCertificate stranger_;
};

TEST_F(CredentialsTest, PlaintextIsRefusedOffLoopback) {
  ServerConfig config = TestServer::StubConfig();
  config.data = folder_.path() / "store";
  for (const char* address : {"0.0.0.0:0", "[::]:0", "192.0.2.1:0"}) {
    config.listen = address;
    const absl::Status status = Server::Start(config).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(status.message()),
                AllOf(HasSubstr(address), HasSubstr("allow_plaintext_off_loopback")));
  }
  config.listen = "0.0.0.0:0";
  config.allow_plaintext_off_loopback = true;
  EXPECT_TRUE(Server::Start(config).ok());
}

TEST_F(CredentialsTest, TlsServesWhoTrustsTheAuthority) {
  const TestServer server(TlsConfig());
  EXPECT_TRUE(Ask(server, Client(authority_)).ok());
  EXPECT_EQ(Ask(server, Client(stranger_)).error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(Ask(server, grpc::InsecureChannelCredentials()).error_code(),
            grpc::StatusCode::UNAVAILABLE);
}

TEST_F(CredentialsTest, OldVersionsOfTlsAreRefused) {
  const TestServer server(TlsConfig());
  EXPECT_FALSE(Speaks(server.server->address(), TLS1_VERSION));
  EXPECT_FALSE(Speaks(server.server->address(), TLS1_1_VERSION));
  EXPECT_TRUE(Speaks(server.server->address(), TLS1_2_VERSION));
  EXPECT_TRUE(Speaks(server.server->address(), TLS1_3_VERSION));
}

TEST_F(CredentialsTest, MutualTlsServesOnlyCertifiedClients) {
  const TestServer server(MutualTlsConfig());
  const TestCertificate client = TestCertificate::SignedBy(authority_, "car-1");
  const TestCertificate forged = TestCertificate::SignedBy(stranger_, "car-1");
  const grpc::Status status = Ask(server, Client(authority_, client));
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(Ask(server, Client(authority_)).error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(Ask(server, Client(authority_, forged)).error_code(), grpc::StatusCode::UNAVAILABLE);
}

TEST_F(CredentialsTest, ACertificateCommonNameIsWhoCalls) {
  const TestServer server(MutualTlsConfig());
  const auto identities = *OpenIdentities(server.folder.path() / "store");
  const auto make = [&](const Principal& principal) {
    return identities->Create(Proof::kCertificate, principal, {}).status();
  };
  ASSERT_TRUE(make({.name = "ops", .role = Role::kAdmin}).ok());
  ASSERT_TRUE(make({.name = "car-1", .role = Role::kVehicle}).ok());
  const auto as = [&](const std::string& common_name) {
    return Ask(server, Client(authority_, TestCertificate::SignedBy(authority_, common_name)));
  };
  const grpc::Status admin = as("ops");
  EXPECT_TRUE(admin.ok()) << admin.error_message();
  const grpc::Status vehicle = as("car-1");
  EXPECT_EQ(vehicle.error_code(), grpc::StatusCode::PERMISSION_DENIED);
  EXPECT_THAT(vehicle.error_message(), AllOf(HasSubstr("car-1"), HasSubstr("vehicle")));
  const grpc::Status unknown = as("car-2");
  EXPECT_EQ(unknown.error_code(), grpc::StatusCode::UNAUTHENTICATED)
      << "signed by the authority, but nobody knows it";
  ASSERT_TRUE(identities->Revoke(1).ok());
  EXPECT_EQ(as("ops").error_code(), grpc::StatusCode::UNAUTHENTICATED);
}

TEST_F(CredentialsTest, NewCertificatesAreServedWithoutARestart) {
  const TestServer server(TlsConfig());
  ASSERT_TRUE(Ask(server, Client(authority_)).ok());
  TestCertificate::SignedBy(stranger_, "server").Write(folder_.path(), "server");
  bool changed = false;
  for (int i = 0; i < 100 && !changed; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    changed = Ask(server, Client(stranger_)).ok();
  }
  EXPECT_TRUE(changed);
  EXPECT_FALSE(Ask(server, Client(authority_)).ok());
}

TEST_F(CredentialsTest, BadFilesAreNamedAtTheStart) {
  ServerConfig config = TlsConfig();
  config.tls_cert = Path("nowhere.pem");
  EXPECT_THAT(ErrorOf(config), AllOf(HasSubstr("tls_cert"), HasSubstr("nowhere.pem")));
  config = TlsConfig();
  config.tls_cert = Path("server.key");
  EXPECT_THAT(ErrorOf(config), HasSubstr("tls_cert"));
  config = TlsConfig();
  config.tls_key = Path("authority.key");
  EXPECT_THAT(ErrorOf(config), AllOf(HasSubstr("tls_key"), HasSubstr("authority.key")))
      << "a key of another certificate";
  config = MutualTlsConfig();
  config.tls_client_ca = Path("server.key");
  EXPECT_THAT(ErrorOf(config), HasSubstr("tls_client_ca"));
}

}  // namespace
}  // namespace dcloc::server
