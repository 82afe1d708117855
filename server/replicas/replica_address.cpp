#include "server/replicas/replica_address.h"

#include <algorithm>
#include <array>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"

namespace dcloc::server {
namespace {

constexpr std::size_t kMaxHost = 253;  // of a name in DNS

// A channel takes these for what comes before an address.
constexpr std::array kSchemes = {"unix", "unix-abstract", "dns", "ipv4", "ipv6", "vsock", "xds"};

bool IsName(absl::string_view host) {
  if (std::ranges::find(kSchemes, absl::AsciiStrToLower(host)) != kSchemes.end()) return false;
  return std::ranges::all_of(host, [](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '-' || c == '_';
  });
}

bool IsBracketed(absl::string_view host) {
  if (host.size() < 4 || host.front() != '[' || host.back() != ']') return false;
  return std::ranges::all_of(host.substr(1, host.size() - 2), [](char c) {
    return absl::ascii_isxdigit(static_cast<unsigned char>(c)) || c == ':' || c == '.';
  });
}

}  // namespace

bool IsReplicaAddress(absl::string_view text) {
  const std::size_t colon = text.rfind(':');
  if (colon == absl::string_view::npos || colon == 0 || colon > kMaxHost) return false;
  const absl::string_view host = text.substr(0, colon);
  const absl::string_view digits = text.substr(colon + 1);
  int port = 0;
  const bool is_port = !digits.empty() && digits.size() <= 5 &&
                       std::ranges::all_of(digits, [](char c) { return c >= '0' && c <= '9'; }) &&
                       absl::SimpleAtoi(digits, &port) && port >= 1 && port <= 65535;
  return is_port && (IsName(host) || IsBracketed(host));
}

}  // namespace dcloc::server
