#pragma once

#include <atomic>
#include <cstdint>

namespace dcloc::server {

/// What became of the scans of sessions whose passes may be kept, and of the passes. Written by any
/// thread.
struct PassCounts {
  std::atomic<std::int64_t> taken_scans = 0;     ///< handed to the writer
  std::atomic<std::int64_t> unworthy_scans = 0;  ///< not TRACKING, uncertain, or a source unsound
  std::atomic<std::int64_t> dropped_scans = 0;   ///< the writer was behind

  std::atomic<std::int64_t> kept = 0;
  std::atomic<std::int64_t> too_short = 0;
  std::atomic<std::int64_t> over_quota = 0;
  std::atomic<std::int64_t> withdrawn = 0;  ///< the consent, meanwhile
  std::atomic<std::int64_t> failed = 0;     ///< the storage
};

}  // namespace dcloc::server
