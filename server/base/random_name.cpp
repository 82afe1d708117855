#include "server/base/random_name.h"

#include <openssl/rand.h>

#include <array>
#include <cstddef>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"

namespace dcloc::server {

absl::StatusOr<std::string> RandomName(int bits, absl::string_view what) {
  std::array<unsigned char, 32> bytes{};
  const int count = bits / 8;
  if (bits <= 0 || bits % 8 != 0 || count > static_cast<int>(bytes.size())) {
    return absl::InternalError(absl::StrCat("a name of ", bits, " bits for ", what));
  }
  if (RAND_bytes(bytes.data(), count) != 1) {
    return absl::InternalError(absl::StrCat("no random bytes for ", what));
  }
  return absl::BytesToHexString(
      {reinterpret_cast<const char*>(bytes.data()), static_cast<std::size_t>(count)});
}

}  // namespace dcloc::server
