#pragma once

#include <atomic>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "absl/strings/string_view.h"
#include "dcloc/v1/recording.pb.h"

namespace dcloc::server {

/// Who takes a session down from its beginning. Called on the session's strand, so it must not
/// wait.
class SessionTap {
 public:
  virtual ~SessionTap() = default;
  virtual void OnOpened(const v1::RecordingHeader& header) = 0;
  virtual void OnScan(const v1::Scan& scan, const v1::LocalizeResponse& answer) = 0;
  /// The session has ended; the last call.
  virtual void OnEnd() = 0;
};

/// Who waits for a vehicle's next session. Thread-safe; costs one atomic read while nobody does.
class TapRequests {
 public:
  /// `tap` gets the next session of the tenant's vehicle, if it is alive then. Who asked first is
  /// served first, one session each.
  void Add(absl::string_view tenant, absl::string_view vehicle_id,
           const std::shared_ptr<SessionTap>& tap);

  /// Who waits for a session of that vehicle, which is being opened; null when nobody does.
  std::shared_ptr<SessionTap> Take(absl::string_view tenant, absl::string_view vehicle_id);

 private:
  using Key = std::pair<std::string, std::string>;

  std::atomic<bool> has_any_ = false;
  std::mutex mutex_;
  std::map<Key, std::deque<std::weak_ptr<SessionTap>>> waiting_;
};

}  // namespace dcloc::server
