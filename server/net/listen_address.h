#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace dcloc::server {

/// HOST:PORT, taken apart.
struct ListenAddress {
  std::string host;  ///< a name or an address, an IPv6 one without its brackets
  int port = 0;

  /// Only this machine can reach it.
  bool IsLoopback() const;

  /// As gRPC takes it: HOST:PORT or [HOST]:PORT.
  std::string ToString() const;
};

/// InvalidArgument names `listen`, the value and what it must be.
absl::StatusOr<ListenAddress> ParseListenAddress(absl::string_view text);

}  // namespace dcloc::server
