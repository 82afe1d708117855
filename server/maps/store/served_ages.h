#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace dcloc::server {

/// How long each of some files has been there unchanged while a server served, kept in a text. The
/// host's clock has no part in it: it may jump, and must not delete. Thread-safe.
class ServedAges {
 public:
  using Age = std::chrono::nanoseconds;

  /// Where the text is kept.
  struct Place {
    std::function<absl::StatusOr<std::string>()> load;  ///< empty when there is none
    std::function<absl::Status(const std::string&)> save;
  };

  explicit ServedAges(Place place) : place_(std::move(place)) {}

  /// Kept in a file.
  explicit ServedAges(const std::filesystem::path& path);

  /// Adds `served`, the time served since the call before, to the ages of files that were there
  /// then with the same size. Others begin at 0, also all of them when the ages have been lost.
  /// `sizes` are those of the files that are there; the result has their ages.
  absl::StatusOr<std::map<std::string, Age>> Advance(
      Age served, const std::map<std::string, std::int64_t>& sizes);

  /// The same for the files of a folder, of which those of age `limit` are removed; returns how
  /// many.
  absl::StatusOr<int> RemoveAged(Age served, Age limit,
                                 const std::vector<std::filesystem::path>& files);

  /// The file begins at 0 again.
  absl::Status Forget(const std::string& name);

 private:
  struct Entry {
    Age age{};
    std::int64_t size_bytes = 0;
    bool operator==(const Entry&) const = default;
  };
  using Entries = std::map<std::string, Entry>;

  absl::StatusOr<Entries> Load() const;
  absl::Status Save(const Entries& entries) const;

  const Place place_;
  std::mutex mutex_;
};

}  // namespace dcloc::server
