#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/base/files.h"
#include "server/base/ticker.h"

namespace dcloc::server {

/// That one process has a store, as long as it lives.
///
/// On one host a lock of the file says so. A network file system may keep locks from other hosts,
/// so the file also names the process, and its time of change is set again and again: whoever finds
/// another host's name waits whether that time still changes. No clocks are compared. What another
/// host takes over from a process that stood still for longer than that wait is not noticed here.
class StoreLock {
 public:
  static constexpr std::chrono::milliseconds kBeat{500};
  static constexpr std::chrono::milliseconds kPatience{3000};

  /// `host` names this one, without a colon. FailedPrecondition when another process has the store.
  static absl::StatusOr<StoreLock> Take(const std::filesystem::path& path, const std::string& host);

  StoreLock(StoreLock&&) noexcept = default;
  StoreLock& operator=(StoreLock&&) = delete;
  ~StoreLock();

 private:
  explicit StoreLock(FileDescriptor file);

  std::shared_ptr<const FileDescriptor> file_;  ///< null once moved from
  std::unique_ptr<Ticker> beat_;
};

}  // namespace dcloc::server
