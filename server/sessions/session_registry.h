#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/config/limits.h"
#include "server/sessions/attachment_state.h"
#include "server/sessions/session_info.h"
#include "server/sessions/session_stream.h"

namespace dcloc::server {

class Session;

struct SessionTimeouts {
  std::chrono::nanoseconds detached_timeout = std::chrono::minutes(1);
  std::chrono::nanoseconds idle_timeout = std::chrono::minutes(10);  ///< 0: for ever
};

/// A session as lists show it.
struct ListedSession {
  std::shared_ptr<SessionInfo> info;
  bool detached = false;
};

/// How many sessions there are, by the state of their last answer: none, then as in
/// LocalizationState.
struct SessionCensus {
  std::array<int, 5> attached{};
  std::array<int, 5> detached{};
};

/// Holds the sessions that are open: each is attached to a stream, or detached and waiting for its
/// client to resume it. Also has the counts over all sessions so far and, for some time, why
/// sessions ended. Thread-safe; localizing a scan does not take its lock.
class SessionRegistry {
 public:
  using Clock = SessionInfo::Clock;
  using Stream = std::weak_ptr<SessionStream>;

  /// `limits` outlives it.
  SessionRegistry(const Limits& limits, const SessionTimeouts& timeouts)
      : limits_(limits), timeouts_(timeouts) {}

  /// Adds a session attached to `stream`. If there are too many sessions, the one that has been
  /// detached for longest is ended; ResourceExhausted if none is detached.
  absl::Status Add(std::shared_ptr<SessionInfo> info, std::shared_ptr<Session> session,
                   Stream stream);

  /// The session of a resume token. NotFound says why it is gone; PermissionDenied for another
  /// principal, InvalidArgument for another vehicle.
  absl::StatusOr<std::shared_ptr<Session>> Find(absl::string_view resume_token,
                                                const Principal& principal,
                                                absl::string_view vehicle_id) const;

  /// Attaches a session to another stream; gives the one that it was attached to. NotFound as
  /// above.
  absl::StatusOr<std::shared_ptr<SessionStream>> Attach(const SessionInfo& info, Stream stream);

  /// Detaches the session from `stream`; does nothing if it is not attached to it.
  void Detach(const SessionInfo& info, const SessionStream& stream);

  /// Removes a session; a later `Find` fails with `reason`. Does nothing if it is not attached to
  /// `stream`.
  void Remove(const SessionInfo& info, const SessionStream& stream, const std::string& reason);

  /// Tells the client and ends a session of the tenant's. NotFound.
  absl::Status End(absl::string_view session_id, absl::string_view tenant,
                   const v1::SessionEnding& ending);

  /// The tenant's sessions in a map.
  std::vector<std::shared_ptr<Session>> SessionsIn(absl::string_view tenant,
                                                   absl::string_view map_name) const;

  /// Ends sessions that have been detached or idle for too long, and cuts off streams that were
  /// told to end and have not.
  void Reap(Clock::time_point now);

  /// Removes all detached sessions.
  void RemoveDetached(const std::string& reason);

  /// At most `limit` sessions of the tenant's with an id above `after_id`, by ascending id.
  std::vector<ListedSession> List(absl::string_view tenant, absl::string_view after_id,
                                  int limit) const;

  /// A session of the tenant's. NotFound says why it is gone where that is still known.
  absl::StatusOr<ListedSession> Get(absl::string_view tenant, absl::string_view session_id);

  /// The same, to be used on its strand.
  absl::StatusOr<std::shared_ptr<Session>> GetSession(absl::string_view tenant,
                                                      absl::string_view session_id);

  /// Of all tenants.
  std::vector<std::shared_ptr<SessionInfo>> All() const;

  int count() const;
  SessionCensus Census() const;
  int max_session_count() const { return limits_.max_session_count; }
  int detached_count() const;
  ScanCounts& totals() { return totals_; }
  std::int64_t resume_count() const;

 private:
  struct Entry {
    std::shared_ptr<SessionInfo> info;
    std::shared_ptr<Session> session;
    Stream stream;
    AttachmentState state = AttachmentState::kAttached;
    Clock::time_point since;  ///< of the state
  };
  using Entries = std::map<std::string, Entry, std::less<>>;
  /// Freed by the caller after the lock: a session may hold the last reference to a map.
  using Released = std::vector<Entry>;

  // With the mutex held.
  static AttachmentAction Take(AttachmentEvent event, Entry* entry);
  /// The same, for events that may end a session: then it is released.
  AttachmentAction Take(AttachmentEvent event, Entries::iterator entry, const std::string& reason,
                        Released* released);
  /// What a session's timeouts bring by `now`, if anything.
  std::optional<AttachmentEvent> DueEvent(const Entry& entry, Clock::time_point now) const;
  Entry* FindAttached(const SessionInfo& info, const SessionStream& stream);
  void Release(Entries::iterator entry, const std::string& reason, Released* released);
  bool EvictLongestDetached(Released* released);
  Entries::iterator FindOf(absl::string_view tenant, absl::string_view session_id);
  void Remember(const SessionDescription& description, const std::string& reason);
  absl::Status Gone(absl::string_view key, absl::string_view what) const;

  const Limits& limits_;
  const SessionTimeouts timeouts_;
  mutable std::mutex mutex_;
  Entries entries_;
  std::map<std::string, std::string, std::less<>> id_of_token_;
  /// Why sessions ended, by id and by token; the oldest are forgotten.
  std::map<std::string, std::string, std::less<>> end_reasons_;
  std::deque<std::string> remembered_;
  std::int64_t resume_count_ = 0;
  ScanCounts totals_;
};

}  // namespace dcloc::server
