#pragma once

#include <filesystem>
#include <string>

namespace dcloc::client {

/// A certificate authority of a test's own, and what it signs, as PEM files in a folder.
struct Certificates {
  std::string ca;
  std::string server_cert;  ///< for "localhost"
  std::string server_key;
  std::string client_cert;
  std::string client_key;
};

/// Makes them in `folder`.
Certificates MakeCertificates(const std::filesystem::path& folder);

}  // namespace dcloc::client
