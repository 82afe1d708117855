#include "server/maps/jobs/map_builds.h"

#include <span>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/base/framed_file.h"
#include "server/base/random_name.h"
#include "server/base/sha256.h"
#include "server/base/status.h"
#include "server/base/within_memory.h"
#include "server/convert/map.h"
#include "server/maps/jobs/known_pose_build.h"
#include "server/maps/jobs/map_build.h"
#include "server/maps/jobs/survey_build.h"
#include "server/maps/jobs/update_build.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

constexpr int kMaxRunningPerTenant = 4;
constexpr std::chrono::milliseconds kTakeInterval(1000);  ///< of looking for what others left
constexpr std::chrono::milliseconds kRenewInterval(2000);
constexpr std::chrono::minutes kOrphanInterval(10);
/// How long storage that is away is asked again: for scans, and to take what came out.
constexpr std::chrono::seconds kPatience(60);

UploadLimits UploadLimitsOf(const Limits& limits) {
  return {.max_map_bytes = std::int64_t{limits.max_map_mib} << 20,
          .max_tenant_bytes = std::int64_t{limits.max_tenant_storage_mib} << 20};
}

const absl::Status& StatusOf(const absl::Status& status) { return status; }

template <typename Value>
const absl::Status& StatusOf(const absl::StatusOr<Value>& answer) {
  return answer.status();
}

/// Asks again while the storage is away, within bounds and until `stopping`.
template <typename Ask>
auto AskPatiently(const Ask& ask, const std::atomic<bool>& stopping) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  auto answer = ask();
  while (absl::IsUnavailable(StatusOf(answer)) && !stopping &&
         std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    answer = ask();
  }
  return answer;
}

v1::MapBuild ReportOf(const BuildRow& row) {
  v1::MapBuild report;
  report.ParseFromString(row.report);
  // Of an attempt that did not end.
  report.clear_drives();
  report.clear_radars();
  report.clear_update();
  return report;
}

}  // namespace

MapBuilds::Running::Running(const BuildRow& taken, const std::string& holder)
    : row(taken),
      lease{.build_id = taken.build_id, .holder = holder, .attempt = taken.attempt_count},
      progress(ReportOf(taken)) {}

MapBuilds::MapBuilds(MapStore& store, PassStore& passes, const Limits& limits)
    : store_(store), passes_(passes), limits_(limits), ticker_(kTakeInterval, [this] { Tick(); }) {
  Wake();
}

MapBuilds::~MapBuilds() {
  stopping_ = true;
  const std::lock_guard lock(mutex_);
  if (running_ != nullptr) running_->progress.Stop();
}

absl::StatusOr<v1::MapBuild> MapBuilds::Start(const std::string& tenant, BuildInput input) {
  absl::StatusOr<std::string> name = RandomName(64, "a build");
  if (!name.ok()) return name.status();
  v1::MapBuild report;
  report.set_scan_count(input.scan_count);
  report.set_method(input.method);
  const BuildRow row{.build_id = *std::move(name),
                     .tenant = tenant,
                     .map_name = input.map_name,
                     .create_time = std::chrono::system_clock::now(),
                     .input_sha256 = input.sha256,
                     .report = report.SerializeAsString()};
  // The row comes last, so that each has its file.
  absl::Status status = store_.build_inputs().Keep(input.spool->path(), row.build_id, input.sha256);
  if (status.ok()) status = queue().Add(row, kMaxRunningPerTenant);
  if (!status.ok()) {
    store_.build_inputs().Remove(row.build_id).IgnoreError();
    return status;
  }
  Wake();
  return MessageOf(row);
}

absl::StatusOr<v1::MapBuild> MapBuilds::Get(absl::string_view tenant,
                                            absl::string_view build_id) const {
  const absl::StatusOr<BuildRow> row = queue().Get(tenant, build_id);
  if (!row.ok()) return row.status();
  return MessageOf(*row);
}

absl::StatusOr<std::vector<v1::MapBuild>> MapBuilds::List(absl::string_view tenant) const {
  const absl::StatusOr<std::vector<BuildRow>> rows = queue().List(tenant);
  if (!rows.ok()) return rows.status();
  std::vector<v1::MapBuild> builds;
  for (const BuildRow& row : *rows) builds.push_back(MessageOf(row));
  return builds;
}

absl::StatusOr<v1::MapBuild> MapBuilds::Cancel(absl::string_view tenant,
                                               absl::string_view build_id) {
  const absl::StatusOr<BuildRow> row = queue().Cancel(tenant, build_id);
  if (!row.ok()) return row.status();
  if (row->state != BuildState::kRunning) {
    store_.build_inputs().Remove(build_id).IgnoreError();
    return MessageOf(*row);
  }
  const std::lock_guard lock(mutex_);
  if (running_ != nullptr && running_->row.build_id == build_id) running_->progress.Stop();
  v1::MapBuild message;
  ToProto(*row, &message);
  return message;
}

v1::MapBuild MapBuilds::MessageOf(const BuildRow& row) const {
  BuildRow newest = row;
  {
    const std::lock_guard lock(mutex_);
    const bool is_here = running_ != nullptr && running_->row.build_id == row.build_id;
    if (is_here && row.state == BuildState::kRunning) {
      newest.report = running_->progress.Get().SerializeAsString();
    }
  }
  v1::MapBuild message;
  ToProto(newest, &message);
  return message;
}

void MapBuilds::Tick() {
  Wake();
  const auto now = std::chrono::steady_clock::now();
  if (now < next_look_for_orphans_) return;
  next_look_for_orphans_ = now + kOrphanInterval;
  RemoveOrphans();
}

void MapBuilds::Wake() {
  if (stopping_ || busy_.exchange(true)) return;
  const absl::Status posted =
      WithinMemory([this] { pool_.Post([this] { BuildAll(); }, Lane::kLengthy); });
  if (!posted.ok()) busy_ = false;  // the ticker tries again
}

void MapBuilds::BuildAll() {
  WithinMemory([this] {
    while (!stopping_ && BuildNext()) continue;
  }).IgnoreError();
  busy_ = false;
}

bool MapBuilds::BuildNext() {
  const absl::StatusOr<std::optional<BuildRow>> row = queue().Take(store_.holder());
  if (!row.ok() && !absl::IsUnavailable(row.status())) {
    spdlog::warn("no map build taken reason={}", Quoted(row.status().message()));
  }
  if (!row.ok() || !row->has_value()) return false;
  return Build(**row);
}

bool MapBuilds::Build(const BuildRow& row) {
  auto running = std::make_shared<Running>(row, store_.holder());
  {
    const std::lock_guard lock(mutex_);
    running_ = running;
    if (stopping_) running->progress.Stop();
  }
  spdlog::info("map build begun build={} tenant={} map={} attempt={}", row.build_id, row.tenant,
               row.map_name, row.attempt_count);
  absl::StatusOr<MapVersionRecord> version = OutOfMemory();
  {
    const Ticker renewal(kRenewInterval, [this, &running] { Renew(*running); });
    WithinMemory([&] { version = Make(*running); }).IgnoreError();
  }
  const absl::Status ended = WithinMemory([&] { End(*running, version); });
  const std::lock_guard lock(mutex_);
  running_.reset();
  return ended.ok();
}

void MapBuilds::Renew(Running& running) const {
  const auto state = queue().Renew(running.lease, running.progress.Get().SerializeAsString());
  if (!state.ok() || *state == LeaseState::kHeld) return;  // away: the lease may outlive that
  if (*state == LeaseState::kLost) running.lost = true;
  running.progress.Stop();
}

absl::StatusOr<MapVersionRecord> MapBuilds::Make(Running& running) const {
  const BuildRow& row = running.row;
  if (row.attempt_count > BuildQueue::kMaxAttempts) {
    return absl::AbortedError(
        absl::StrFormat("%d servers ended before they had built it; it may be what ended them",
                        BuildQueue::kMaxAttempts));
  }
  const std::filesystem::path path = store_.incoming().folder() / ("build-" + row.build_id);
  FramedReader spool(path);
  absl::Status status = AskPatiently(
      [&] { return store_.build_inputs().Fetch(row.build_id, row.input_sha256, path); }, stopping_);
  if (!status.ok()) return WithPrefix("the scans: ", status);
  v1::StartMapBuildRequest header;
  status = spool.Begin();
  const absl::StatusOr<bool> there = status.ok() ? spool.Next(&header) : status;
  if (!there.ok()) return there.status();
  const absl::StatusOr<BuildRequest> request = FromProto(header.header());
  if (!request.ok()) return request.status();
  const auto bytes = MakeBytes(running, *request, header.header().method(), spool);
  if (!bytes.ok()) return bytes.status();
  running.progress.Tell("storing the map", 0.0);
  status = Confirm(running);
  if (!status.ok()) return status;
  return AskPatiently([&] { return Keep(running, request->activate, *bytes); }, stopping_);
}

absl::StatusOr<std::vector<std::byte>> MapBuilds::MakeBytes(Running& running,
                                                            const BuildRequest& request,
                                                            v1::MapBuildMethod method,
                                                            FramedReader& spool) const {
  switch (method) {
    case v1::MAP_BUILD_METHOD_SURVEY:
      return BuildBySurvey(request, spool, running.progress);
    case v1::MAP_BUILD_METHOD_UPDATE:
      return BuildFromPasses(request,
                             {.store = store_,
                              .passes = passes_,
                              .tenant = running.row.tenant,
                              .map_name = running.row.map_name,
                              .folder = store_.incoming().folder(),
                              .max_bytes = std::int64_t{limits_.max_map_mib} << 20},
                             running.progress);
    default:
      return BuildAtKnownPoses(request, spool, running.progress);
  }
}

absl::Status MapBuilds::Confirm(Running& running) const {
  const auto state = AskPatiently(
      [&] { return queue().Renew(running.lease, running.progress.Get().SerializeAsString()); },
      stopping_);
  if (!state.ok()) return state.status();
  if (*state == LeaseState::kLost) running.lost = true;
  if (*state != LeaseState::kHeld || running.progress.stopped()) return BuildStopped();
  return absl::OkStatus();
}

absl::StatusOr<MapVersionRecord> MapBuilds::Keep(const Running& running, bool activate,
                                                 const std::vector<std::byte>& bytes) const {
  Sha256 hash;
  hash.Update(bytes);
  absl::StatusOr<Upload> upload =
      Upload::Begin(store_,
                    {.tenant = running.row.tenant,
                     .map_name = running.row.map_name,
                     .size_bytes = static_cast<std::int64_t>(bytes.size()),
                     .sha256 = hash.Finish(),
                     .activate = activate},
                    UploadLimitsOf(limits_));
  if (!upload.ok()) return upload.status();
  constexpr std::size_t kPart = std::size_t{1} << 20;
  const absl::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  for (std::size_t offset = 0; offset < text.size(); offset += kPart) {
    absl::Status status =
        upload->Append(static_cast<std::int64_t>(offset), text.substr(offset, kPart));
    if (!status.ok()) return status;
  }
  return upload->Finish();
}

void MapBuilds::End(Running& running, const absl::StatusOr<MapVersionRecord>& version) const {
  const BuildRow& row = running.row;
  const bool interrupted = !version.ok() && (stopping_ || running.lost);
  if (interrupted) {
    if (!running.lost) queue().GiveBack(running.lease).IgnoreError();  // else the lease ends
    spdlog::info("map build given back build={} tenant={} map={}", row.build_id, row.tenant,
                 row.map_name);
    return;
  }
  v1::MapBuild report = running.progress.Get();
  BuildState state = BuildState::kDone;
  if (version.ok()) {
    convert::ToProto(*version, report.mutable_version());
  } else {
    state = absl::IsCancelled(version.status()) ? BuildState::kCancelled : BuildState::kFailed;
    report.set_error_code(static_cast<std::int32_t>(version.status().code()));
    report.set_error_message(std::string(version.status().message()));
  }
  const auto ended = AskPatiently(
      [&] { return queue().End(running.lease, state, report.SerializeAsString()); }, stopping_);
  if (ended.ok()) store_.build_inputs().Remove(row.build_id).IgnoreError();
  spdlog::info("map build ended build={} tenant={} map={} scans={} version={} reason={}",
               row.build_id, row.tenant, row.map_name, report.scan_count(),
               version.ok() ? version->version : 0, Quoted(version.status().message()));
}

/// Files of builds that never were, as their server died before it added the row, or that have
/// ended, as it died before it removed the file. One that has just come may still get its row.
void MapBuilds::RemoveOrphans() {
  const auto files = store_.build_inputs().List();
  const auto wanted = queue().ListRunning();
  if (!files.ok() || !wanted.ok()) return;
  std::set<std::string> orphans;
  for (const auto& [name, size_bytes] : *files) orphans.insert(name);
  for (const std::string& build_id : *wanted) orphans.erase(build_id);
  for (const std::string& name : orphans) {
    if (!orphans_.contains(name)) continue;
    spdlog::info("scans of no map build removed build={}", name);
    store_.build_inputs().Remove(name).IgnoreError();
  }
  orphans_ = std::move(orphans);
}

}  // namespace dcloc::server
