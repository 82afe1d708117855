#include "server/config/certificates.h"

#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <memory>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "server/base/small_file.h"
#include "server/base/status.h"

namespace dcloc::server {
namespace {

template <auto Free>
struct Freed {
  template <typename T>
  void operator()(T* object) const {
    Free(object);
  }
};

using X509Pointer = std::unique_ptr<X509, Freed<&X509_free>>;
using KeyPointer = std::unique_ptr<EVP_PKEY, Freed<&EVP_PKEY_free>>;
using ContextPointer = std::unique_ptr<SSL_CTX, Freed<&SSL_CTX_free>>;
using BioPointer = std::unique_ptr<BIO, Freed<&BIO_free_all>>;

/// A setting that names a file.
struct FileSetting {
  const char* key;
  const std::string& path;
};

FileSetting ChainOf(const ServerConfig& config) { return {"tls_cert", config.tls_cert}; }
FileSetting KeyOf(const ServerConfig& config) { return {"tls_key", config.tls_key}; }
FileSetting AuthorityOf(const ServerConfig& config) {
  return {"tls_client_ca", config.tls_client_ca};
}

absl::Status Fault(const FileSetting& setting, absl::string_view fault) {
  return absl::InvalidArgumentError(
      absl::StrCat(setting.key, " is ", Quoted(setting.path), ": ", fault));
}

/// With OpenSSL's own reason.
absl::Status OpenSslFault(const FileSetting& setting, absl::string_view fault) {
  std::array<char, 256> reason{};
  ERR_error_string_n(ERR_peek_last_error(), reason.data(), reason.size());
  ERR_clear_error();
  return Fault(setting, absl::StrCat(fault, " (", reason.data(), ")"));
}

BioPointer Memory(const std::string& text) {
  return BioPointer(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

/// A key with a passphrase must not make the program ask for it.
int NoPassphrase(char* /*buffer*/, int /*size*/, int /*writes*/, void* /*user*/) { return 0; }

absl::StatusOr<std::vector<X509Pointer>> ParseChain(const FileSetting& setting,
                                                    const std::string& pem) {
  ERR_clear_error();
  std::vector<X509Pointer> chain;
  const BioPointer memory = Memory(pem);
  while (X509* certificate = PEM_read_bio_X509(memory.get(), nullptr, &NoPassphrase, nullptr)) {
    chain.emplace_back(certificate);
  }
  const bool at_end = ERR_GET_REASON(ERR_peek_last_error()) == PEM_R_NO_START_LINE;
  if (!at_end)
    return OpenSslFault(setting, absl::StrCat("certificate ", chain.size() + 1, " does not parse"));
  ERR_clear_error();
  if (chain.empty()) return Fault(setting, "there is no certificate (PEM) in it");
  return chain;
}

SystemTime TimeOf(const ASN1_TIME* time) {
  std::tm parts{};
  ASN1_TIME_to_tm(time, &parts);
  return std::chrono::time_point_cast<SystemTime::duration>(
      std::chrono::system_clock::from_time_t(timegm(&parts)));
}

absl::Status CheckDates(const FileSetting& setting, const std::vector<X509Pointer>& chain,
                        SystemTime now) {
  for (std::size_t i = 0; i < chain.size(); ++i) {
    const SystemTime begin = TimeOf(X509_get0_notBefore(chain[i].get()));
    const SystemTime end = TimeOf(X509_get0_notAfter(chain[i].get()));
    if (now >= end) {
      return Fault(setting, absl::StrCat("certificate ", i + 1, " expired at ", DateText(end)));
    }
    if (now < begin) {
      return Fault(setting,
                   absl::StrCat("certificate ", i + 1, " is not valid before ", DateText(begin)));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckSignatures(const FileSetting& setting, const std::vector<X509Pointer>& chain) {
  for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
    X509* const issuer = chain[i + 1].get();
    if (X509_check_issued(issuer, chain[i].get()) != X509_V_OK ||
        X509_verify(chain[i].get(), X509_get0_pubkey(issuer)) != 1) {
      ERR_clear_error();
      return Fault(setting, absl::StrCat("certificate ", i + 1, " is not signed by certificate ",
                                         i + 2, ", which follows it"));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckKey(const ServerConfig& config, X509* certificate, const std::string& pem) {
  ERR_clear_error();
  const BioPointer memory = Memory(pem);
  const KeyPointer key(PEM_read_bio_PrivateKey(memory.get(), nullptr, &NoPassphrase, nullptr));
  if (key == nullptr) return OpenSslFault(KeyOf(config), "there is no private key (PEM) in it");
  if (X509_check_private_key(certificate, key.get()) != 1) {
    return OpenSslFault(KeyOf(config), "it is not the key of tls_cert");
  }
  const ContextPointer context(SSL_CTX_new(TLS_server_method()));
  if (SSL_CTX_use_certificate(context.get(), certificate) != 1) {
    return OpenSslFault(ChainOf(config), "OpenSSL does not accept it");
  }
  if (SSL_CTX_use_PrivateKey(context.get(), key.get()) != 1) {
    return OpenSslFault(KeyOf(config), "OpenSSL does not accept it");
  }
  return absl::OkStatus();
}

absl::Status ReadInto(const FileSetting& setting, std::string* content) {
  absl::StatusOr<std::string> read = ReadSmallFile(setting.path);
  if (!read.ok()) return Fault(setting, read.status().message());
  *content = *std::move(read);
  return absl::OkStatus();
}

}  // namespace

std::string DateText(SystemTime time) {
  return absl::FormatTime("%Y-%m-%dT%H:%M:%SZ", absl::FromChrono(time), absl::UTCTimeZone());
}

absl::StatusOr<CertificateFiles> ReadCertificateFiles(const ServerConfig& config) {
  CertificateFiles files;
  absl::Status status = ReadInto(ChainOf(config), &files.chain);
  if (status.ok()) status = ReadInto(KeyOf(config), &files.key);
  if (status.ok() && !config.tls_client_ca.empty()) {
    status = ReadInto(AuthorityOf(config), &files.client_ca);
    if (status.ok() && files.client_ca.empty()) {
      status = Fault(AuthorityOf(config), "it is empty");
    }
  }
  if (!status.ok()) return status;
  return files;
}

absl::StatusOr<SystemTime> CheckCertificates(const ServerConfig& config,
                                             const CertificateFiles& files, SystemTime now) {
  const absl::StatusOr<std::vector<X509Pointer>> chain = ParseChain(ChainOf(config), files.chain);
  if (!chain.ok()) return chain.status();
  absl::Status status = CheckDates(ChainOf(config), *chain, now);
  if (status.ok()) status = CheckSignatures(ChainOf(config), *chain);
  if (status.ok()) status = CheckKey(config, chain->front().get(), files.key);
  if (status.ok() && !files.client_ca.empty()) {
    status = ParseChain(AuthorityOf(config), files.client_ca).status();
  }
  if (!status.ok()) return status;
  SystemTime expire_time = SystemTime::max();
  for (const X509Pointer& certificate : *chain) {
    expire_time = std::min(expire_time, TimeOf(X509_get0_notAfter(certificate.get())));
  }
  return expire_time;
}

}  // namespace dcloc::server
