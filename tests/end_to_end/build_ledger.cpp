#include "tests/end_to_end/build_ledger.h"

#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/maps/catalogue/build_queue.h"
#include "tests/end_to_end/is_gone.h"
#include "tests/server/fixtures/messages.h"

namespace dcloc {
namespace {

constexpr int kScans = 40;
constexpr std::chrono::milliseconds kPause(20);

/// Of a vehicle that drives ahead at 10 m/s.
v1::PosedScan PosedScan(int number) {
  v1::PosedScan posed;
  *posed.mutable_scan() = server::ScanMessage(number);
  *posed.mutable_t_map_vehicle() = server::IdentityPose();
  posed.mutable_t_map_vehicle()->mutable_translation_m()->set_x(0.77 * number);
  return posed;
}

}  // namespace

absl::Status BuildLedger::Work(client::MapClient maps) {
  absl::Status status;
  while (status.ok()) status = Step(maps);
  return IsGone(status) ? absl::OkStatus() : status;
}

absl::Status BuildLedger::Step(client::MapClient& maps) {
  v1::MapBuildHeader header;
  header.set_map_name(map_name_);
  header.set_drive_name(absl::StrCat("drive-", ++build_count_));  // or it would be the same file
  header.set_activate(true);
  *header.mutable_rig() = server::OpenMessage().rig();
  int scan_count = 0;
  const absl::StatusOr<v1::MapBuild> started = maps.StartBuild(header, [&](v1::PosedScan* scan) {
    *scan = PosedScan(scan_count);
    return scan_count++ < kScans;
  });
  if (!started.ok()) return started.status();
  running_.insert(started->build_id());
  ++acknowledged_count_;
  while (running_.contains(started->build_id())) {
    std::this_thread::sleep_for(kPause);
    const absl::StatusOr<v1::MapBuild> build = maps.GetBuild(started->build_id());
    if (!build.ok()) return build.status();
    if (absl::Status status = TakeEnd(*build); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status BuildLedger::TakeEnd(const v1::MapBuild& build) {
  if (build.state() == v1::MAP_BUILD_STATE_RUNNING) return absl::OkStatus();
  running_.erase(build.build_id());
  if (build.state() == v1::MAP_BUILD_STATE_DONE) {
    versions_[build.version().version()] = build.version().sha256();
    return absl::OkStatus();
  }
  if (build.attempt_count() > server::BuildQueue::kMaxAttempts) {
    ++given_up_count_;
    return absl::OkStatus();
  }
  return absl::InternalError(absl::StrCat("build ", build.build_id(), " of ", map_name_,
                                          " ended in state ", build.state(), ": ",
                                          build.error_message()));
}

absl::Status BuildLedger::Check(client::MapClient& maps) {
  const std::vector<std::string> ids(running_.begin(), running_.end());
  for (const std::string& id : ids) {
    const absl::StatusOr<v1::MapBuild> build = maps.GetBuild(id);
    if (!build.ok())
      return absl::InternalError(
          absl::StrCat("build ", id, " is lost: ", build.status().message()));
    if (absl::Status status = TakeEnd(*build); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status BuildLedger::Finish(client::MapClient& maps, std::chrono::seconds bound) {
  const auto end = std::chrono::steady_clock::now() + bound;
  while (!running_.empty()) {
    if (absl::Status status = Check(maps); !status.ok()) return status;
    if (std::chrono::steady_clock::now() > end) {
      return absl::InternalError(
          absl::StrCat(running_.size(), " builds of ", map_name_, " do not end"));
    }
    std::this_thread::sleep_for(kPause);
  }
  const auto versions = maps.ListVersions(map_name_);
  // No build need have been begun, or made, before its server was killed.
  if (absl::IsNotFound(versions.status()) && versions_.empty()) return absl::OkStatus();
  if (!versions.ok()) return versions.status();
  for (const v1::MapVersion& version : *versions) {
    files_.insert(version.sha256());
    versions_.erase(version.version());
  }
  if (versions_.empty()) return absl::OkStatus();
  return absl::InternalError(absl::StrCat("version ", versions_.begin()->first, " of ", map_name_,
                                          " was built and is not there"));
}

}  // namespace dcloc
