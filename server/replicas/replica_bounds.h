#pragma once

#include <chrono>

namespace dcloc::server {

/// How long another server is waited for. Nothing else says so; a caller's own deadline may be
/// earlier.
struct ReplicaBounds {
  /// An answer that is at hand, and the begin of a stream. A server that is gone costs this much.
  std::chrono::milliseconds answer{2'000};

  /// An answer that a search of the map comes before. Only the one that has the session is asked,
  /// after it has said so within `answer`.
  std::chrono::milliseconds search{60'000};
};

}  // namespace dcloc::server
