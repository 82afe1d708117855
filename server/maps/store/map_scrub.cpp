#include "server/maps/store/map_scrub.h"

#include "server/base/status.h"
#include "server/base/within_memory.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {

MapScrub::MapScrub(Catalogue& catalogue, MapFiles& files, const MapScrubOptions& options)
    : catalogue_(catalogue), files_(files), options_(options) {
  if (options_.max_bytes_per_s == 0.0) return;
  state_.last_pass_end = std::chrono::system_clock::now();
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

ScrubState MapScrub::state() const {
  const std::lock_guard lock(mutex_);
  ScrubState state = state_;
  state.damaged_file_count = static_cast<int>(damaged_.size());
  return state;
}

void MapScrub::Run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    const auto begin = std::chrono::steady_clock::now();
    // Without memory it looks again at the next pass.
    WithinMemory([&] { Pass(stop); }).IgnoreError();
    const auto next = begin + options_.pass_interval;
    if (!Sleep(next - std::chrono::steady_clock::now(), stop)) return;
  }
}

void MapScrub::Pass(const std::stop_token& stop) {
  const auto wanted = catalogue_.ListFiles();
  if (!wanted.ok()) {
    spdlog::warn("map files not checked reason={}", Quoted(wanted.status().message()));
    return;
  }
  {
    // Files that no version has any more are nobody's trouble.
    std::set<std::string> names;
    for (const auto& [sha256, size_bytes] : *wanted) names.insert(sha256);
    const std::lock_guard lock(mutex_);
    std::erase_if(damaged_, [&](const std::string& sha256) { return !names.contains(sha256); });
  }
  bool all_read = true;
  for (const auto& [sha256, size_bytes] : *wanted) {
    all_read = Check(sha256, stop) && all_read;
    if (stop.stop_requested()) return;
  }
  if (!all_read) return;
  const std::lock_guard lock(mutex_);
  ++state_.pass_count;
  state_.last_pass_end = std::chrono::system_clock::now();
}

bool MapScrub::Check(const std::string& sha256, const std::stop_token& stop) {
  const absl::Status status = files_.Check(sha256, [&](std::size_t piece_bytes) {
    {
      const std::lock_guard lock(mutex_);
      state_.checked_bytes += static_cast<std::int64_t>(piece_bytes);
    }
    const std::chrono::duration<double> pause(static_cast<double>(piece_bytes) /
                                              options_.max_bytes_per_s);
    return Sleep(std::chrono::duration_cast<std::chrono::nanoseconds>(pause), stop);
  });
  // Of a storage that is away nothing is known.
  if (absl::IsCancelled(status) || absl::IsUnavailable(status)) return false;
  const absl::StatusOr<bool> needed = catalogue_.HasFile(sha256);
  if (!needed.ok() || !*needed) return true;  // deleted meanwhile
  const std::lock_guard lock(mutex_);
  if (status.ok()) {
    if (damaged_.erase(sha256) > 0) spdlog::info("map file whole again sha256={}", sha256);
  } else if (damaged_.insert(sha256).second) {
    spdlog::error("map file damaged, upload it again sha256={} reason={}", sha256,
                  Quoted(status.message()));
  }
  return true;
}

bool MapScrub::Sleep(std::chrono::nanoseconds duration, const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  never_.wait_for(lock, stop, duration, [] { return false; });
  return !stop.stop_requested();
}

}  // namespace dcloc::server
