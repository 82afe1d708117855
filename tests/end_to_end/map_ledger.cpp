#include "tests/end_to_end/map_ledger.h"

#include <fstream>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/sdk/sha256.h"
#include "tests/core/map/synthetic_map.h"
#include "tests/end_to_end/is_gone.h"

namespace dcloc {
namespace {

absl::Status Problem(const std::string& map_name, const std::string& what) {
  return absl::InternalError(absl::StrCat(map_name, ": ", what));
}

}  // namespace

MapLedger::Counts MapLedger::Sum(const std::vector<std::unique_ptr<MapLedger>>& ledgers) {
  Counts sum;
  for (const auto& ledger : ledgers) {
    sum.acknowledged += ledger->counts_.acknowledged;
    sum.doubtful += ledger->counts_.doubtful;
    sum.finished += ledger->counts_.finished;
  }
  return sum;
}

absl::Status MapLedger::Work(client::MapClient maps) {
  absl::Status status;
  while (status.ok()) status = Step(maps);
  if (!IsGone(status)) return Problem(map_name_, absl::StrCat("refused: ", status.message()));
  ++counts_.doubtful;
  return absl::OkStatus();
}

absl::Status MapLedger::Step(client::MapClient& maps) {
  absl::Status status;
  const double choice = std::uniform_real_distribution(0.0, 1.0)(random_);
  if (versions_.empty() || choice < 0.5) {
    if (!Chance(0.1) || last_file_.path.empty()) {
      absl::StatusOr<File> file = MakeFile();
      if (!file.ok()) return file.status();
      last_file_ = *std::move(file);
    }
    status = Upload(maps, last_file_, Chance(0.5));
  } else if (choice < 0.7) {
    status = Activate(maps);
  } else if (choice < 0.8) {
    status = RollBack(maps);
  } else {
    status = Delete(maps);
  }
  if (status.ok()) doubt_ = {};
  return status;
}

absl::Status MapLedger::Upload(client::MapClient& maps, const File& file, bool activate,
                               std::chrono::milliseconds give_up_after) {
  doubt_ = {.uploaded_sha256 = file.sha256, .activates = activate};
  const auto version =
      maps.Upload(file.path, map_name_, {.activate = activate, .give_up_after = give_up_after});
  if (!version.ok()) return version.status();
  ++counts_.acknowledged;
  versions_[version->version()] = file.sha256;
  if (activate) BecomesActive(version->version());
  return absl::OkStatus();
}

absl::Status MapLedger::Activate(client::MapClient& maps) {
  const std::int64_t version = AnyVersion();
  doubt_ = {.activated = version};
  const auto map = maps.Activate(map_name_, version);
  if (!map.ok()) return map.status();
  ++counts_.acknowledged;
  BecomesActive(version);
  return absl::OkStatus();
}

absl::Status MapLedger::RollBack(client::MapClient& maps) {
  if (previous_ == 0) return absl::OkStatus();
  doubt_ = {.activated = previous_};
  const auto map = maps.RollBack(map_name_);
  if (!map.ok()) return map.status();
  ++counts_.acknowledged;
  BecomesActive(previous_);
  return absl::OkStatus();
}

absl::Status MapLedger::Delete(client::MapClient& maps) {
  const std::int64_t version = AnyVersion();
  if (version == active_) return absl::OkStatus();
  doubt_ = {.deleted = version};
  absl::Status status = maps.DeleteVersion(map_name_, version);
  const bool is_held = servers_ == Servers::kSeveral && absl::IsFailedPrecondition(status);
  if (is_held) return absl::OkStatus();
  if (!status.ok()) return status;
  ++counts_.acknowledged;
  versions_.erase(version);
  if (previous_ == version) previous_ = 0;
  return absl::OkStatus();
}

absl::Status MapLedger::Check(client::MapClient& maps) {
  absl::Status status = TakeOver(maps);
  if (status.ok()) status = FinishUpload(maps);
  if (!status.ok()) return Problem(map_name_, std::string(status.message()));
  doubt_ = {};
  return absl::OkStatus();
}

absl::Status MapLedger::TakeOver(client::MapClient& maps) {
  const auto map = maps.Get(map_name_);
  if (absl::IsNotFound(map.status()) && versions_.empty()) return absl::OkStatus();
  if (!map.ok()) return map.status();
  const auto versions = maps.ListVersions(map_name_);
  if (!versions.ok()) return versions.status();
  Versions there;
  for (const v1::MapVersion& version : *versions) there[version.version()] = version.sha256();
  absl::Status status = CheckVersions(there);
  if (status.ok()) status = CheckActive(map->active_version(), there);
  if (!status.ok()) return status;
  versions_ = std::move(there);
  active_ = map->active_version();
  previous_ = map->previous_version();
  if (versions_.empty()) return absl::OkStatus();
  // It comes with its hash checked.
  return maps.Download(map_name_, AnyVersion(), absl::StrCat(folder_, "/", map_name_, ".download"))
      .status();
}

absl::Status MapLedger::FinishUpload(client::MapClient& maps) {
  if (doubt_.uploaded_sha256.empty()) return absl::OkStatus();
  ++counts_.finished;
  // What a killed server was storing, others may store once its lease is over.
  constexpr std::chrono::seconds kLongerThanALease(40);
  return Upload(maps, last_file_, doubt_.activates, kLongerThanALease);
}

absl::Status MapLedger::CheckVersions(const Versions& there) const {
  for (const auto& [version, sha256] : versions_) {
    const auto found = there.find(version);
    if (found == there.end() && version == doubt_.deleted) continue;
    if (found == there.end()) {
      return absl::DataLossError(absl::StrFormat("version %d is lost", version));
    }
    if (found->second != sha256) {
      return absl::DataLossError(absl::StrFormat("version %d has another file", version));
    }
  }
  for (const auto& [version, sha256] : there) {
    if (versions_.contains(version) || sha256 == doubt_.uploaded_sha256) continue;
    return absl::DataLossError(absl::StrFormat("version %d came from nowhere", version));
  }
  return absl::OkStatus();
}

absl::Status MapLedger::CheckActive(std::int64_t version, const Versions& there) const {
  if (version == active_ || version == doubt_.activated) return absl::OkStatus();
  const auto found = there.find(version);
  if (doubt_.activates && found != there.end() && found->second == doubt_.uploaded_sha256) {
    return absl::OkStatus();
  }
  return absl::DataLossError(absl::StrFormat("version %d is active; it was %d", version, active_));
}

std::set<std::string> MapLedger::Files() const {
  std::set<std::string> files;
  for (const auto& [version, sha256] : versions_) files.insert(sha256);
  return files;
}

absl::StatusOr<MapLedger::File> MapLedger::MakeFile() {
  const auto keyframes = std::uniform_int_distribution<std::size_t>(10, 800)(random_);
  SyntheticMap map(keyframes, 300);  // 13 kB each
  map.name = absl::StrCat(map_name_, "-", ++file_count_);
  map.info.name_size_bytes = static_cast<std::uint32_t>(map.name.size());
  const std::vector<std::byte> bytes = map.Bytes();
  File file{.path = absl::StrCat(folder_, "/", map_name_, ".dclm"), .sha256 = {}};
  std::ofstream(file.path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  absl::StatusOr<std::string> sha256 = client::Sha256OfFile(file.path);
  if (!sha256.ok()) return sha256.status();
  file.sha256 = *std::move(sha256);
  return file;
}

std::int64_t MapLedger::AnyVersion() {
  const auto index = std::uniform_int_distribution<std::size_t>(0, versions_.size() - 1)(random_);
  return std::next(versions_.begin(), static_cast<std::ptrdiff_t>(index))->first;
}

void MapLedger::BecomesActive(std::int64_t version) {
  if (version == active_) return;
  previous_ = std::exchange(active_, version);
}

}  // namespace dcloc
