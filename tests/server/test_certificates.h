#pragma once

#include <filesystem>
#include <memory>
#include <string>

struct evp_pkey_st;
struct x509_st;

namespace dcloc::server {

/// A certificate with its private key.
class TestCertificate {
 public:
  /// An authority that signs itself.
  static TestCertificate Authority(const std::string& common_name);

  /// Signed by `authority`; good for servers on 127.0.0.1 and for clients.
  static TestCertificate SignedBy(const TestCertificate& authority, const std::string& common_name);

  std::string CertificatePem() const;
  std::string KeyPem() const;

  /// Writes `name`.pem and `name`.key.
  void Write(const std::filesystem::path& folder, const std::string& name) const;

 private:
  TestCertificate(const std::string& common_name, const TestCertificate* issuer);

  std::shared_ptr<evp_pkey_st> key_;
  std::shared_ptr<x509_st> certificate_;
};

}  // namespace dcloc::server
