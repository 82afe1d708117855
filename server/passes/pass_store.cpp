#include "server/passes/pass_store.h"

#include <utility>

#include "server/base/files.h"
#include "server/base/pseudonym.h"
#include "server/base/random_name.h"
#include "server/base/status.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {

absl::Status PassStore::CheckKeeps() const {
  if (!key_.empty()) return absl::OkStatus();
  return absl::FailedPreconditionError(
      "this server keeps no passes: it has no key for pseudonyms (setting pass_key)");
}

absl::Status PassStore::GiveConsent(absl::string_view tenant, const ConsentRow& consent) {
  absl::Status status = CheckKeeps();
  return status.ok() ? rows_->GiveConsent(tenant, consent) : status;
}

absl::StatusOr<int> PassStore::WithdrawConsent(absl::string_view tenant,
                                               const ConsentRow& consent) {
  // Without the key an identity's passes are not found.
  if (consent.subject == ConsentSubject::kIdentity) {
    if (absl::Status status = CheckKeeps(); !status.ok()) return status;
  }
  const absl::StatusOr<std::vector<std::string>> ids =
      rows_->WithdrawConsent(tenant, consent, PseudonymOf("identity", tenant, consent.name));
  if (!ids.ok()) return ids.status();
  RemoveFiles(*ids);
  return static_cast<int>(ids->size());
}

absl::StatusOr<bool> PassStore::MayKeep(absl::string_view tenant, absl::string_view map_name,
                                        absl::string_view identity_name) {
  if (key_.empty()) return false;
  return rows_->MayKeep(tenant, map_name, identity_name);
}

absl::Status PassStore::Add(const NewPass& pass, const std::filesystem::path& path,
                            const PassBounds& bounds) {
  absl::StatusOr<std::string> name = RandomName(64, "a pass");
  if (!name.ok()) return name.status();
  const SystemTime now = std::chrono::system_clock::now();
  const PassRow row{.pass_id = *std::move(name),
                    .tenant = pass.tenant,
                    .map_name = pass.map_name,
                    .map_version = pass.map_version,
                    .vehicle = PseudonymOf("vehicle", pass.tenant, pass.vehicle_id),
                    .identity = PseudonymOf("identity", pass.tenant, pass.identity_name),
                    .scan_count = pass.scan_count,
                    .size_bytes = pass.size_bytes,
                    .first_stamp_ns = pass.first_stamp_ns,
                    .last_stamp_ns = pass.last_stamp_ns,
                    .sha256 = pass.sha256,
                    .create_time = now,
                    .expire_time = now + bounds.retention};
  // The row comes last, so that each has its file.
  absl::Status status = files_->Keep(path, row.pass_id, row.sha256);
  if (status.ok()) status = rows_->Add(row, pass.identity_name, bounds.quota);
  if (status.ok()) return status;
  RemoveFiles({row.pass_id});
  RemoveFile(path).IgnoreError();
  return status;
}

absl::StatusOr<int> PassStore::RemoveExpired(SystemTime now) {
  const absl::StatusOr<std::vector<std::string>> ids = rows_->RemoveExpired(now);
  if (!ids.ok()) return ids.status();
  RemoveFiles(*ids);
  return static_cast<int>(ids->size());
}

absl::StatusOr<int> PassStore::RemoveOrphans() {
  const auto files = files_->List();
  if (!files.ok()) return files.status();
  const auto ids = rows_->ListIds();
  if (!ids.ok()) return ids.status();
  std::set<std::string> orphans;
  for (const auto& [name, size_bytes] : *files) orphans.insert(name);
  for (const std::string& id : *ids) orphans.erase(id);
  std::vector<std::string> twice;
  for (const std::string& name : orphans) {
    if (orphans_.contains(name)) twice.push_back(name);
  }
  RemoveFiles(twice);
  orphans_ = std::move(orphans);
  return static_cast<int>(twice.size());
}

std::string PassStore::PseudonymOf(absl::string_view kind, absl::string_view tenant,
                                   absl::string_view name) const {
  return key_.empty() ? "" : Pseudonym(key_, {kind, tenant, name});
}

/// One that cannot be removed is an orphan.
void PassStore::RemoveFiles(const std::vector<std::string>& ids) {
  for (const std::string& id : ids) {
    const absl::Status status = files_->Remove(id);
    if (status.ok()) continue;
    spdlog::warn("pass not removed pass={} reason={}", id, Quoted(status.message()));
  }
}

}  // namespace dcloc::server
