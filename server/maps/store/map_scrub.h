#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>

#include "server/maps/catalogue/catalogue.h"
#include "server/maps/store/map_files.h"

namespace dcloc::server {

struct MapScrubOptions {
  double max_bytes_per_s = 20e6;  ///< 0: none is read
  /// A pass begins this long after the one before has begun, or later.
  std::chrono::nanoseconds pass_interval = std::chrono::hours(1);
};

/// What the scrub has found so far.
struct ScrubState {
  std::int64_t checked_bytes = 0;
  int damaged_file_count = 0;  ///< missing or damaged when they were read last
  int pass_count = 0;
  /// When all files had been read last; before that, when the scrub began; none if it reads
  /// nothing.
  std::optional<SystemTime> last_pass_end;
};

/// Reads every map file against its hash, slowly, again and again, on a thread of its own, and logs
/// what it finds: a file may decay long before anyone needs it. It changes nothing; an upload of
/// the same file mends it. Thread-safe.
class MapScrub {
 public:
  /// Both outlive it.
  MapScrub(Catalogue& catalogue, MapFiles& files, const MapScrubOptions& options);

  ScrubState state() const;

 private:
  void Run(const std::stop_token& stop);
  void Pass(const std::stop_token& stop);
  /// False when the file could not be read.
  bool Check(const std::string& sha256, const std::stop_token& stop);
  /// Waits; false when the scrub is to end.
  bool Sleep(std::chrono::nanoseconds duration, const std::stop_token& stop);

  Catalogue& catalogue_;
  MapFiles& files_;
  const MapScrubOptions options_;
  mutable std::mutex mutex_;
  std::condition_variable_any never_;
  ScrubState state_;               ///< but for the count of damaged files
  std::set<std::string> damaged_;  ///< hashes
  std::jthread thread_;            ///< last: it uses the others
};

}  // namespace dcloc::server
