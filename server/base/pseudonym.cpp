#include "server/base/pseudonym.h"

#include <openssl/evp.h>

#include <array>
#include <cstdlib>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"

namespace dcloc::server {

std::string Pseudonym(absl::string_view key, std::initializer_list<absl::string_view> parts) {
  std::string text = "dcloc pseudonym 1";
  // With their sizes, so that no other parts give the same text.
  for (const absl::string_view part : parts) absl::StrAppend(&text, " ", part.size(), " ", part);
  std::array<unsigned char, 32> mac{};
  std::size_t size = 0;
  const bool done = EVP_Q_mac(nullptr, "HMAC", nullptr, "SHA256", nullptr, key.data(), key.size(),
                              reinterpret_cast<const unsigned char*>(text.data()), text.size(),
                              mac.data(), mac.size(), &size) != nullptr;
  // Only where memory or OpenSSL itself is gone. Zeros would be everybody's.
  if (!done || size != mac.size()) std::abort();
  return absl::BytesToHexString(
      absl::string_view(reinterpret_cast<const char*>(mac.data()), mac.size() / 2));
}

}  // namespace dcloc::server
