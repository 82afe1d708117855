#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/objects/object_store.h"

namespace dcloc::server {

/// Files beside the maps, of one kind, each under a name of letters, digits, "-" and "_" that is
/// given once: scans of builds, passes. Servers that share maps share them. Thread-safe; calls
/// may block on storage. Unavailable: the storage is away.
class KeptFiles {
 public:
  virtual ~KeptFiles() = default;

  /// Moves the local file `path`, whose bytes have this hash, there. Durable when it returns.
  virtual absl::Status Keep(const std::filesystem::path& path, absl::string_view name,
                            absl::string_view sha256) = 0;

  /// Copies a file to `path`. NotFound; DataLoss: its bytes have another hash.
  virtual absl::Status Fetch(absl::string_view name, absl::string_view sha256,
                             const std::filesystem::path& path) = 0;

  /// Removes a file if it is there.
  virtual absl::Status Remove(absl::string_view name) = 0;

  /// The names of all files, and their sizes in bytes.
  virtual absl::StatusOr<std::map<std::string, std::int64_t>> List() = 0;
};

/// In a folder, which several processes may share.
class KeptFolder final : public KeptFiles {
 public:
  /// Makes the folder if it is not there.
  static absl::StatusOr<std::unique_ptr<KeptFolder>> Open(const std::filesystem::path& folder);

  absl::Status Keep(const std::filesystem::path& path, absl::string_view name,
                    absl::string_view sha256) override;
  absl::Status Fetch(absl::string_view name, absl::string_view sha256,
                     const std::filesystem::path& path) override;
  absl::Status Remove(absl::string_view name) override;
  absl::StatusOr<std::map<std::string, std::int64_t>> List() override;

 private:
  explicit KeptFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}
  std::filesystem::path PathOf(absl::string_view name) const { return folder_ / std::string(name); }

  const std::filesystem::path folder_;
};

/// In an object store, below a prefix.
class KeptObjects final : public KeptFiles {
 public:
  KeptObjects(std::shared_ptr<ObjectStore> objects, std::string prefix)
      : objects_(std::move(objects)), prefix_(std::move(prefix)) {}

  absl::Status Keep(const std::filesystem::path& path, absl::string_view name,
                    absl::string_view sha256) override;
  absl::Status Fetch(absl::string_view name, absl::string_view sha256,
                     const std::filesystem::path& path) override;
  absl::Status Remove(absl::string_view name) override;
  absl::StatusOr<std::map<std::string, std::int64_t>> List() override;

 private:
  std::string KeyOf(absl::string_view name) const;

  const std::shared_ptr<ObjectStore> objects_;
  const std::string prefix_;
};

}  // namespace dcloc::server
