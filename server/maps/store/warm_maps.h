#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <string>
#include <utility>

#include "absl/strings/string_view.h"

namespace dcloc::server {

/// Keeps versions in memory that new sessions get, though none may use them just now, which is not
/// to hold them in the catalogue: those used
/// last, and together not more than so many bytes. Not thread-safe.
class WarmMaps {
 public:
  /// Map name and version.
  using Key = std::pair<std::string, std::int64_t>;

  /// `max_bytes` 0 keeps none.
  explicit WarmMaps(std::int64_t max_bytes) : max_bytes_(max_bytes) {}

  /// Keeps `map`, of `size_bytes`, as the one used last, and drops what there is no room for any
  /// more. One that is larger than all the room is not kept, and costs no other its place.
  void Keep(const Key& key, std::shared_ptr<const void> map, std::int64_t size_bytes);

  /// Drops the versions of a map but for those two.
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
