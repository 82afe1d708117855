#include "server/config/credentials.h"

#include <grpc/grpc.h>
#include <grpc/grpc_security.h>

#include <chrono>
#include <mutex>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "server/base/status.h"
#include "server/base/within_memory.h"
#include "server/net/listen_address.h"

namespace dcloc::server {
namespace {

/// gRPC asks at each handshake whether there are other certificates than before.
class CertificateFetcher {
 public:
  explicit CertificateFetcher(std::shared_ptr<const ServedCertificates> certificates)
      : certificates_(std::move(certificates)) {}

  static grpc_ssl_certificate_config_reload_status Fetch(
      void* self, grpc_ssl_server_certificate_config** config) {
    return static_cast<CertificateFetcher*>(self)->FetchNew(config);
  }

 private:
  grpc_ssl_certificate_config_reload_status FetchNew(grpc_ssl_server_certificate_config** config) {
    const std::lock_guard lock(mutex_);
    std::shared_ptr<const CertificateFiles> files = certificates_->files();
    if (files == fetched_) return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_UNCHANGED;
    const grpc_ssl_pem_key_cert_pair pair{.private_key = files->key.c_str(),
                                          .cert_chain = files->chain.c_str()};
    // gRPC asserts that there are roots. Without an authority no client is asked for a certificate,
    // so that any will do.
    const std::string& roots = files->client_ca.empty() ? files->chain : files->client_ca;
    *config = grpc_ssl_server_certificate_config_create(roots.c_str(), &pair, 1);
    fetched_ = std::move(files);
    return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_NEW;
  }

  const std::shared_ptr<const ServedCertificates> certificates_;
  std::mutex mutex_;
  std::shared_ptr<const CertificateFiles> fetched_;
};

absl::string_view ViewOf(const grpc_slice& slice) {
  return {reinterpret_cast<const char*>(GRPC_SLICE_START_PTR(slice)), GRPC_SLICE_LENGTH(slice)};
}

/// Called by gRPC when a call's headers have come.
void AdmitCall(void* gate, grpc_auth_context* connection, const grpc_metadata* headers,
               std::size_t header_count, grpc_process_auth_metadata_done_cb done, void* call) {
  absl::string_view path;
  bool has_proof = grpc_auth_context_peer_is_authenticated(connection) != 0;
  for (std::size_t i = 0; i < header_count; ++i) {
    const absl::string_view key = ViewOf(headers[i].key);
    if (key == ":path") path = ViewOf(headers[i].value);
    has_proof |= key == "authorization";
  }
  const grpc::Status status = ToGrpc(WithinMemory([&] {
    return static_cast<CallGate*>(gate)->Admit(connection, path, has_proof,
                                               RateLimit::Clock::now());
  }));
  done(call, nullptr, 0, nullptr, 0, static_cast<grpc_status_code>(status.error_code()),
       status.ok() ? nullptr : status.error_message().c_str());
}

/// gRPC's C++ interface has no credentials whose certificates are fetched, and none in plaintext
/// that see a call's headers; its C interface has.
class GatedCredentials final : public grpc::ServerCredentials {
 public:
  /// `certificates`: null for plaintext.
  GatedCredentials(std::shared_ptr<CallGate> gate,
                   const std::shared_ptr<const ServedCertificates>& certificates)
      : gate_(std::move(gate)) {
    if (certificates == nullptr) {
      credentials_ = grpc_insecure_server_credentials_create();
    } else {
      fetcher_ = std::make_unique<CertificateFetcher>(certificates);
      const bool mutual = !certificates->files()->client_ca.empty();
      credentials_ = grpc_ssl_server_credentials_create_with_options(
          grpc_ssl_server_credentials_create_options_using_config_fetcher(
              mutual ? GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY
                     : GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE,
              &CertificateFetcher::Fetch, fetcher_.get()));
    }
    grpc_server_credentials_set_auth_metadata_processor(
        credentials_, {.process = &AdmitCall, .destroy = nullptr, .state = gate_.get()});
  }
  ~GatedCredentials() override { grpc_server_credentials_release(credentials_); }

  void SetAuthMetadataProcessor(
      const std::shared_ptr<grpc::AuthMetadataProcessor>& /*processor*/) override {}

 private:
  int AddPortToServer(const std::string& address, grpc_server* server) override {
    return grpc_server_add_http2_port(server, address.c_str(), credentials_);
  }

  const std::shared_ptr<CallGate> gate_;
  std::unique_ptr<CertificateFetcher> fetcher_;  ///< null in plaintext
  grpc_server_credentials* credentials_ = nullptr;
};

absl::Status CheckPlaintext(const ServerConfig& config) {
  const absl::StatusOr<ListenAddress> address = ParseListenAddress(config.listen);
  if (!address.ok()) return address.status();
  if (address->IsLoopback() || config.allow_plaintext_off_loopback) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      "listen is ", Quoted(config.listen),
      ", which other machines can reach, and there is no tls_cert; give tls_cert and tls_key, or "
      "allow_plaintext_off_loopback"));
}

}  // namespace

absl::StatusOr<Credentials> MakeCredentials(const ServerConfig& config,
                                            std::shared_ptr<CallGate> gate) {
  if (config.tls_cert.empty()) {
    if (absl::Status status = CheckPlaintext(config); !status.ok()) return status;
    return Credentials{.credentials = std::make_shared<GatedCredentials>(std::move(gate), nullptr),
                       .certificates = nullptr};
  }
  absl::StatusOr<std::shared_ptr<ServedCertificates>> certificates =
      ServedCertificates::Load(config, std::chrono::system_clock::now());
  if (!certificates.ok()) return certificates.status();
  return Credentials{
      .credentials = std::make_shared<GatedCredentials>(std::move(gate), *certificates),
      .certificates = *certificates};
}

}  // namespace dcloc::server
