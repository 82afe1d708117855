#include "server/config/credentials.h"

#include <grpcpp/security/tls_certificate_provider.h>
#include <grpcpp/security/tls_credentials_options.h>
#include <openssl/err.h>
#include <openssl/ssl.h>

#include <array>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/base/status.h"
#include "server/net/listen_address.h"

namespace dcloc::server {
namespace {

constexpr unsigned kRefreshInterval_s = 1;

absl::Status FileError(const char* key, const std::string& path) {
  std::array<char, 256> reason{};
  ERR_error_string_n(ERR_peek_last_error(), reason.data(), reason.size());
  ERR_clear_error();
  return absl::InvalidArgumentError(
      absl::StrFormat("%s is %s: %s", key, Quoted(path), reason.data()));
}

/// gRPC would start with broken files and then refuse every client; better to say so at once.
absl::Status CheckFiles(const ServerConfig& config) {
  ERR_clear_error();
  const std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)> context(SSL_CTX_new(TLS_server_method()),
                                                                  &SSL_CTX_free);
  if (SSL_CTX_use_certificate_chain_file(context.get(), config.tls_cert.c_str()) != 1) {
    return FileError("tls_cert", config.tls_cert);
  }
  // Also checks that the key is the certificate's.
  if (SSL_CTX_use_PrivateKey_file(context.get(), config.tls_key.c_str(), SSL_FILETYPE_PEM) != 1) {
    return FileError("tls_key", config.tls_key);
  }
  if (!config.tls_client_ca.empty() &&
      SSL_CTX_load_verify_locations(context.get(), config.tls_client_ca.c_str(), nullptr) != 1) {
    return FileError("tls_client_ca", config.tls_client_ca);
  }
  return absl::OkStatus();
}

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

absl::StatusOr<std::shared_ptr<grpc::ServerCredentials>> MakeCredentials(
    const ServerConfig& config) {
  using grpc::experimental::FileWatcherCertificateProvider;
  if (config.tls_cert.empty()) {
    if (absl::Status status = CheckPlaintext(config); !status.ok()) return status;
    return grpc::InsecureServerCredentials();
  }
  if (absl::Status status = CheckFiles(config); !status.ok()) return status;
  const bool mutual = !config.tls_client_ca.empty();
  grpc::experimental::TlsServerCredentialsOptions options(
      mutual ? std::make_shared<FileWatcherCertificateProvider>(
                   config.tls_key, config.tls_cert, config.tls_client_ca, kRefreshInterval_s)
             : std::make_shared<FileWatcherCertificateProvider>(config.tls_key, config.tls_cert,
                                                                kRefreshInterval_s));
  options.watch_identity_key_cert_pairs();
  if (mutual) {
    options.watch_root_certs();
    options.set_cert_request_type(GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY);
  }
  return grpc::experimental::TlsServerCredentials(options);
}

}  // namespace dcloc::server
