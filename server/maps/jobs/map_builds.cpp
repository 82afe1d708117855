#include "server/maps/jobs/map_builds.h"

#include <algorithm>
#include <span>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "core/odometry/drive_stamps.h"
#include "core/odometry/ego_motion.h"
#include "server/base/random_name.h"
#include "server/base/sha256.h"
#include "server/base/status.h"
#include "server/base/within_memory.h"
#include "server/convert/geometry.h"
#include "server/convert/scan.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

constexpr int kMaxRunningPerTenant = 4;
/// Ended ones too are remembered, for who comes to ask.
constexpr std::size_t kMaxRemembered = 200;

absl::Status NoSuchBuild(absl::string_view build_id) {
  return absl::NotFoundError(absl::StrCat("build_id is ", Quoted(build_id),
                                          "; there is no such build, or it ended too long ago"));
}

}  // namespace

MapBuilds::MapBuilds(MapStore& store) : store_(store) {
  for (const LedgerEntry& entry : store.builds().interrupted()) {
    auto build = std::make_shared<Build>();
    build->request.tenant = entry.tenant;
    build->record = {.build_id = entry.build_id,
                     .map_name = entry.map_name,
                     .state = BuildState::kFailed,
                     .scan_count = entry.scan_count,
                     .create_time = entry.create_time,
                     .error = absl::AbortedError("the server was restarted before the build was "
                                                 "done, and its scans are gone: start it again")};
    builds_.push_back(std::move(build));
  }
  ForgetOldest();
}

MapBuilds::~MapBuilds() {
  stopping_ = true;
  const std::lock_guard lock(mutex_);
  for (const auto& build : builds_) build->cancelled = true;
}

absl::StatusOr<BuildRecord> MapBuilds::Start(BuildRequest request,
                                             std::unique_ptr<ScanSpool> scans) {
  absl::StatusOr<std::string> name = RandomName(64, "a build");
  if (!name.ok()) return name.status();
  if (absl::Status status = scans->BeginReading(); !status.ok()) return status;
  auto build = std::make_shared<Build>();
  build->record = {.build_id = *std::move(name),
                   .map_name = request.map_name,
                   .scan_count = scans->scan_count(),
                   .create_time = std::chrono::system_clock::now()};
  build->request = std::move(request);
  build->scans = std::move(scans);
  const std::lock_guard lock(mutex_);
  const auto running = std::ranges::count_if(builds_, [&](const auto& other) {
    return other->request.tenant == build->request.tenant &&
           other->record.state == BuildState::kRunning;
  });
  if (running >= kMaxRunningPerTenant) {
    return absl::ResourceExhaustedError(
        absl::StrFormat("%d builds are under way, which is the limit", kMaxRunningPerTenant));
  }
  absl::Status status = store_.builds().Add({.tenant = build->request.tenant,
                                             .build_id = build->record.build_id,
                                             .map_name = build->record.map_name,
                                             .scan_count = build->record.scan_count,
                                             .create_time = build->record.create_time});
  if (!status.ok()) return status;
  builds_.push_back(build);
  status = WithinMemory([&] { pool_.Post([this, build] { Run(*build); }, Lane::kLengthy); });
  if (!status.ok()) {
    builds_.pop_back();
    store_.builds().Remove(build->record.build_id);
    return status;
  }
  ForgetOldest();
  return RecordOf(*build);
}

absl::StatusOr<BuildRecord> MapBuilds::Get(absl::string_view tenant,
                                           absl::string_view build_id) const {
  const std::lock_guard lock(mutex_);
  const std::shared_ptr<Build> build = Find(tenant, build_id);
  if (build == nullptr) return NoSuchBuild(build_id);
  return RecordOf(*build);
}

std::vector<BuildRecord> MapBuilds::List(absl::string_view tenant) const {
  const std::lock_guard lock(mutex_);
  std::vector<BuildRecord> records;
  for (auto build = builds_.rbegin(); build != builds_.rend(); ++build) {
    if ((*build)->request.tenant == tenant) records.push_back(RecordOf(**build));
  }
  return records;
}

absl::StatusOr<BuildRecord> MapBuilds::Cancel(absl::string_view tenant,
                                              absl::string_view build_id) {
  const std::lock_guard lock(mutex_);
  const std::shared_ptr<Build> build = Find(tenant, build_id);
  if (build == nullptr) return NoSuchBuild(build_id);
  build->cancelled = true;
  return RecordOf(*build);
}

void MapBuilds::Run(Build& build) {
  absl::StatusOr<MapVersionRecord> version = OutOfMemory();
  WithinMemory([&] { version = Make(build); }).IgnoreError();
  const std::lock_guard lock(mutex_);
  build.scans.reset();
  BuildRecord& record = build.record;
  // One that the server's end interrupts is left for the next process to tell of.
  if (version.ok() || !stopping_) store_.builds().Remove(record.build_id);
  if (version.ok()) {
    record.state = BuildState::kDone;
    record.version = *version;
  } else {
    record.state =
        absl::IsCancelled(version.status()) ? BuildState::kCancelled : BuildState::kFailed;
    record.error = version.status();
  }
  spdlog::info("map build ended build={} tenant={} map={} scans={} version={} reason={}",
               record.build_id, build.request.tenant, record.map_name, record.scan_count,
               version.ok() ? version->version : 0, Quoted(version.status().message()));
}

absl::StatusOr<MapVersionRecord> MapBuilds::Make(Build& build) const {
  const absl::StatusOr<std::vector<std::byte>> bytes = AddScans(build);
  if (!bytes.ok()) return bytes.status();
  if (build.cancelled) return absl::CancelledError("cancelled");
  return Keep(build.request, *bytes);
}

// How late radars stamp their scans is known after the last scan only. Scans that are not valid are
// left to AddScans, which names them.
absl::StatusOr<MeasuredStamps> MapBuilds::StampsOf(Build& build) const {
  DriveStamps stamps(build.request.rig);
  if (!stamps.IsNeeded()) return MeasuredStamps{.rig = build.request.rig};
  v1::PosedScan message;
  Scan scan;
  while (!build.cancelled) {
    const absl::StatusOr<bool> there = build.scans->Next(&message);
    if (!there.ok()) return there.status();
    if (!*there) {
      if (absl::Status status = build.scans->BeginReading(); !status.ok()) return status;
      return stamps.Measured();
    }
    if (message.begins_pass()) stamps.BeginPass();
    if (convert::FromProto(message.scan(), build.request.rig, &scan).ok()) stamps.Add(scan);
  }
  return absl::CancelledError("cancelled");
}

absl::StatusOr<std::vector<std::byte>> MapBuilds::AddScans(Build& build) const {
  const BuildRequest& request = build.request;
  const absl::StatusOr<MeasuredStamps> stamps = StampsOf(build);
  if (!stamps.ok()) return stamps.status();
  const Rig& rig = stamps->rig;
  MapBuilderOptions options = request.options;
  options.stamp_delay_s = stamps->mean_delay_s;
  absl::StatusOr<MapBuilder> builder = MapBuilder::Create(rig, options);
  if (!builder.ok()) return builder.status();
  EgoMotion ego_motion;
  v1::PosedScan message;
  Scan scan;
  while (!build.cancelled) {
    const absl::StatusOr<bool> there = build.scans->Next(&message);
    if (!there.ok()) return there.status();
    if (!*there) return builder->Build();
    if (message.begins_pass() && build.done_scan_count > 0) {
      builder->BeginPass();
      ego_motion = EgoMotion();
    }
    absl::Status status = convert::FromProto(message.scan(), request.rig, &scan);
    const absl::StatusOr<Pose3> pose = convert::FromProto(message.t_map_vehicle(), "t_map_vehicle");
    if (status.ok()) status = pose.status();
    if (status.ok()) {
      const EgoVelocity& velocity = ego_motion.Advance(scan, *rig.Find(scan.radar_id));
      status = builder->Add(scan, *pose, velocity);
    }
    if (!status.ok())
      return WithPrefix(absl::StrCat("scan ", build.done_scan_count.load(), ": "), status);
    ++build.done_scan_count;
  }
  return absl::CancelledError("cancelled");
}

absl::StatusOr<MapVersionRecord> MapBuilds::Keep(const BuildRequest& request,
                                                 const std::vector<std::byte>& bytes) const {
  Sha256 hash;
  hash.Update(bytes);
  absl::StatusOr<Upload> upload =
      Upload::Begin(store_,
                    {.tenant = request.tenant,
                     .map_name = request.map_name,
                     .size_bytes = static_cast<std::int64_t>(bytes.size()),
                     .sha256 = hash.Finish(),
                     .activate = request.activate},
                    request.limits);
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

std::shared_ptr<MapBuilds::Build> MapBuilds::Find(absl::string_view tenant,
                                                  absl::string_view build_id) const {
  const auto build = std::ranges::find_if(builds_, [&](const auto& candidate) {
    return candidate->request.tenant == tenant && candidate->record.build_id == build_id;
  });
  return build == builds_.end() ? nullptr : *build;
}

BuildRecord MapBuilds::RecordOf(const Build& build) {
  BuildRecord record = build.record;
  record.done_scan_count = build.done_scan_count;
  return record;
}

void MapBuilds::ForgetOldest() {
  while (builds_.size() > kMaxRemembered) {
    const auto ended = std::ranges::find_if(
        builds_, [](const auto& build) { return build->record.state != BuildState::kRunning; });
    if (ended == builds_.end()) return;
    builds_.erase(ended);
  }
}

}  // namespace dcloc::server
