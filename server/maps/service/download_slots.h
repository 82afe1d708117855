#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "absl/status/statusor.h"

namespace dcloc::server {

/// Counts the downloads that are under way. Each holds a message of a map in memory for as long as
/// its caller does not read, so there are bounds: in all, and for each caller. Thread-safe.
class DownloadSlots {
 public:
  struct Bounds {
    int total = 0;
    int caller = 0;  ///< of one caller
  };

  /// A slot for a download of `caller`, given back when its last holder goes. ResourceExhausted
  /// names the setting that is reached, and its value.
  absl::StatusOr<std::shared_ptr<void>> Take(const std::string& caller, const Bounds& bounds);

  /// How many are taken.
  int count() const;

 private:
  struct Counts {
    std::mutex mutex;
    int total = 0;
    std::map<std::string, int> of_callers;
  };

  const std::shared_ptr<Counts> counts_ = std::make_shared<Counts>();
};

}  // namespace dcloc::server
