#include "server/identity/token.h"

#include <openssl/rand.h>

#include <array>
#include <cstddef>
#include <span>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "server/base/sha256.h"

namespace dcloc::server {
namespace {

/// Says what a leaked string is, to people and to scanners of repositories.
constexpr char kTokenPrefix[] = "dcloc_";
constexpr std::size_t kTokenBytes = 32;

}  // namespace

absl::StatusOr<std::string> NewToken() {
  std::array<unsigned char, kTokenBytes> bytes{};
  if (RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1) {
    return absl::InternalError("no random bytes for a token");
  }
  return absl::StrCat(kTokenPrefix,
                      absl::WebSafeBase64Escape(absl::string_view(
                          reinterpret_cast<const char*>(bytes.data()), bytes.size())));
}

std::string HashOfToken(absl::string_view token) {
  Sha256 hash;
  hash.Update(std::as_bytes(std::span(token.data(), token.size())));
  return hash.Finish();
}

}  // namespace dcloc::server
