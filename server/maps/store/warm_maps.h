#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <string>
#include <utility>

#include "absl/strings/string_view.h"

namespace dcloc::server {

/// Keeps active versions and canaries in memory when no session uses them: those used last, up to a
/// bound in bytes. Keeping a version warm takes no hold in the catalogue. Not thread-safe.
class WarmMaps {
 public:
  /// Map name and version.
  using Key = std::pair<std::string, std::int64_t>;

  /// `max_bytes` 0 keeps none.
  explicit WarmMaps(std::int64_t max_bytes) : max_bytes_(max_bytes) {}

  /// Keeps `map`, of `size_bytes`, as the one used last, and drops the least recently used ones
  /// beyond the bound. A map larger than the bound is not kept, and drops no other.
  void Keep(const Key& key, std::shared_ptr<const void> map, std::int64_t size_bytes);

  /// Drops all versions of a map except those two.
  void KeepOnly(absl::string_view map_name, std::int64_t version, std::int64_t other_version);

  bool Has(const Key& key) const;
  std::int64_t size_bytes() const { return size_bytes_; }

 private:
  struct Entry {
    Key key;
    std::shared_ptr<const void> map;
    std::int64_t size_bytes;
  };
  using Entries = std::list<Entry>;

  Entries::iterator Drop(Entries::iterator entry);

  const std::int64_t max_bytes_;
  std::int64_t size_bytes_ = 0;
  Entries entries_;  ///< the one used last is the first one
};

}  // namespace dcloc::server
