#pragma once

#include <atomic>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "dcloc/v1/localization_service.pb.h"
#include "server/convert/answer.h"
#include "server/convert/position_fix.h"
#include "server/convert/session.h"
#include "server/maps/catalogue/catalogue.h"

namespace dcloc::server {

/// How a session that is recorded began.
struct RecordingStart {
  const v1::OpenSession& open;  ///< as the client sent it
  OpenedSession session;        ///< without its secret
  SystemTime open_time;
  std::string map_sha256;
};

/// Records a session from its opening to its end. Called on the session's strand, so it must not
/// wait.
class RecordingSubscriber {
 public:
  virtual ~RecordingSubscriber() = default;
  virtual void OnOpened(const RecordingStart& start) = 0;
  /// `scan` is as the client sent it; a dropped scan has only its number.
  virtual void OnScan(const v1::Scan& scan, const ScanAnswer& answer) = 0;
  /// Whether it can keep position fixes; if not, the first one ends it.
  virtual bool TakesFixes() const = 0;
  /// `fix` is as the client sent it, or as somebody proposed it.
  virtual void OnFix(const v1::PositionFix& fix, const FixAnswer& answer) = 0;
  /// The last call. OK when the session has ended, an error when it cannot be recorded.
  virtual void OnEnd(const absl::Status& status) = 0;
};

/// The subscribers that wait for a vehicle's next session. Thread-safe; costs one atomic read while
/// there is none.
class RecordingRequests {
 public:
  /// `subscriber` gets the next session of the tenant's vehicle, if it still exists then.
  /// Subscribers are served in the order of their requests, one session each.
  void Add(absl::string_view tenant, absl::string_view vehicle_id,
           const std::shared_ptr<RecordingSubscriber>& subscriber);

  /// `subscriber` waits no more; it may just have been taken.
  void Forget(const RecordingSubscriber& subscriber);

  /// The subscriber that waits for a session of that vehicle, which is being opened; null if there
  /// is none.
  std::shared_ptr<RecordingSubscriber> Take(absl::string_view tenant, absl::string_view vehicle_id);

 private:
  using Key = std::pair<std::string, std::string>;

  std::atomic<bool> has_any_ = false;
  std::mutex mutex_;
  std::map<Key, std::deque<std::weak_ptr<RecordingSubscriber>>> waiting_;
};

}  // namespace dcloc::server
