#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/maps/store/kept_files.h"
#include "server/passes/pass_rows.h"

namespace dcloc::server {

/// A pass that is to be kept. It names its vehicle and identity, which the store does not keep.
struct NewPass {
  std::string tenant;
  std::string map_name;  ///< without the tenant
  std::int64_t map_version = 0;
  std::string identity_name;
  std::string vehicle_id;
  std::int64_t scan_count = 0;
  std::int64_t size_bytes = 0;
  std::int64_t first_stamp_ns = 0;
  std::int64_t last_stamp_ns = 0;
  std::string sha256;
};

/// Bounds on what is kept, and for how long.
struct PassBounds {
  PassQuota quota;
  std::chrono::seconds retention{0};
};

/// Passes beside the maps: rows, files, consents, bounds and an end. Thread-safe; calls may block
/// on storage.
class PassStore {
 public:
  /// `key` is of the pseudonyms; empty: passes are not kept, as nobody could tell vehicles apart.
  PassStore(std::unique_ptr<PassRows> rows, std::unique_ptr<KeptFiles> files, std::string key)
      : rows_(std::move(rows)), files_(std::move(files)), key_(std::move(key)) {}

  /// FailedPrecondition names the setting that is missing to keep passes.
  absl::Status CheckKeeps() const;

  /// FailedPrecondition as of `CheckKeeps`.
  absl::Status GiveConsent(absl::string_view tenant, const ConsentRow& consent);

  /// Removes what was kept under it too; gives how many passes that were. FailedPrecondition as of
  /// `CheckKeeps` for an identity, whose passes only the key finds.
  absl::StatusOr<int> WithdrawConsent(absl::string_view tenant, const ConsentRow& consent);

  /// Whether passes of such a session are kept: both consent, and there is a key.
  absl::StatusOr<bool> MayKeep(absl::string_view tenant, absl::string_view map_name,
                               absl::string_view identity_name);

  /// Moves the local file `path` into the store. Errors of `PassRows::Add`; then the file is gone
  /// all the same.
  absl::Status Add(const NewPass& pass, const std::filesystem::path& path,
                   const PassBounds& bounds);

  /// Copies a pass's file to `path`. NotFound when it was removed meanwhile.
  absl::Status Fetch(const PassRow& pass, const std::filesystem::path& path) {
    return files_->Fetch(pass.pass_id, pass.sha256, path);
  }

  /// Removes passes whose time is over; gives how many.
  absl::StatusOr<int> RemoveExpired(SystemTime now);

  /// Removes files without a pass, which a server left that died; those that the call before found
  /// too, as one that has just come may still get its row. Not for several threads at once.
  absl::StatusOr<int> RemoveOrphans();

  PassRows& rows() { return *rows_; }

 private:
  std::string PseudonymOf(absl::string_view kind, absl::string_view tenant,
                          absl::string_view name) const;
  void RemoveFiles(const std::vector<std::string>& ids);

  const std::unique_ptr<PassRows> rows_;
  const std::unique_ptr<KeptFiles> files_;
  const std::string key_;
  std::set<std::string> orphans_;
};

}  // namespace dcloc::server
