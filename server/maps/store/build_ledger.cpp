#include "server/maps/store/build_ledger.h"

#include <algorithm>
#include <fstream>
#include <span>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/base/files.h"
#include "server/base/status.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

/// Lines: tenant, map, scans, when it began.
std::string TextOf(const LedgerEntry& entry) {
  return absl::StrCat(entry.tenant, "\n", entry.map_name, "\n", entry.scan_count, "\n",
                      entry.create_time.time_since_epoch().count(), "\n");
}

/// False for what was cut off by a crash while it was written: its client was never told.
bool Read(const std::filesystem::path& path, LedgerEntry* entry) {
  std::ifstream file(path);
  std::int64_t create_time_ns = 0;
  std::getline(file, entry->tenant);
  std::getline(file, entry->map_name);
  file >> entry->scan_count >> create_time_ns;
  entry->build_id = path.filename().string();
  entry->create_time = SystemTime(std::chrono::nanoseconds(create_time_ns));
  return file.get() == '\n';
}

}  // namespace

absl::StatusOr<std::unique_ptr<BuildLedger>> BuildLedger::Open(
    const std::filesystem::path& folder) {
  if (absl::Status status = CreateFolders(folder); !status.ok()) return status;
  std::unique_ptr<BuildLedger> ledger(new BuildLedger(folder));
  std::error_code error;
  std::vector<std::filesystem::path> paths;
  std::filesystem::directory_iterator entry(folder, error);
  for (; !error && entry != std::filesystem::end(entry); entry.increment(error)) {
    paths.push_back(entry->path());
  }
  if (error) return FileError(error, folder);
  for (const std::filesystem::path& path : paths) {
    LedgerEntry interrupted;
    if (Read(path, &interrupted)) ledger->interrupted_.push_back(std::move(interrupted));
    if (absl::Status status = RemoveFile(path); !status.ok()) return status;
  }
  std::ranges::sort(ledger->interrupted_, {}, [](const LedgerEntry& interrupted) {
    return std::pair(interrupted.create_time, interrupted.build_id);
  });
  if (!ledger->interrupted_.empty()) {
    spdlog::warn("map builds interrupted count={}", ledger->interrupted_.size());
  }
  return ledger;
}

absl::Status BuildLedger::Add(const LedgerEntry& entry) const {
  const absl::StatusOr<FileDescriptor> file = OpenOrCreate(PathOf(entry.build_id));
  if (!file.ok()) return file.status();
  const std::string text = TextOf(entry);
  absl::Status status = WriteAll(*file, std::as_bytes(std::span(text)));
  if (status.ok()) status = Sync(*file);
  if (status.ok()) status = SyncFolder(folder_);
  return status;
}

void BuildLedger::Remove(absl::string_view build_id) const {
  if (const absl::Status status = RemoveFile(PathOf(build_id)); !status.ok()) {
    spdlog::warn("map build not forgotten reason={}", Quoted(status.message()));
  }
}

std::filesystem::path BuildLedger::PathOf(absl::string_view build_id) const {
  return folder_ / std::string(build_id);
}

}  // namespace dcloc::server
