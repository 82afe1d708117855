#pragma once

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/base/clock.h"
#include "server/config/config.h"

namespace dcloc::server {

/// What a TLS server shows, and whom it trusts: the contents of its files (PEM).
struct CertificateFiles {
  std::string chain;
  std::string key;
  std::string client_ca;  ///< empty: clients need no certificate

  friend bool operator==(const CertificateFiles&, const CertificateFiles&) = default;
};

/// Reads `tls_cert`, `tls_key` and `tls_client_ca`. Errors name the setting and the file.
absl::StatusOr<CertificateFiles> ReadCertificateFiles(const ServerConfig& config);

/// Checks that TLS works with them at `now`: all parse, the key is the certificate's, each
/// certificate of the chain is valid and signed by the one that follows, and OpenSSL accepts them.
/// Returns when the first of the chain expires. InvalidArgument names the setting and the file.
absl::StatusOr<SystemTime> CheckCertificates(const ServerConfig& config,
                                             const CertificateFiles& files, SystemTime now);

/// "2030-01-31T12:00:00Z".
std::string DateText(SystemTime time);

}  // namespace dcloc::server
