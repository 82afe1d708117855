#include "server/sessions/session_registry.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/time/time.h"
#include "server/base/status.h"
#include "server/base/within_memory.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

/// Two for each ended session: by id and by token.
constexpr std::size_t kMaxRemembered = 4096;
/// For a client that was told that its session ends, to read that.
constexpr std::chrono::seconds kEndGrace(5);

std::string Text(std::chrono::nanoseconds duration) {
  return absl::FormatDuration(absl::FromChrono(duration));
}

bool IsAttachedTo(const std::weak_ptr<SessionStream>& attached, const SessionStream& stream) {
  return attached.lock().get() == &stream;
}

}  // namespace

absl::Status SessionRegistry::Add(std::shared_ptr<SessionInfo> info,
                                  std::shared_ptr<Session> session, Stream stream) {
  Released released;
  const std::lock_guard lock(mutex_);
  const int max = limits_.max_session_count;
  if (static_cast<int>(entries_.size()) >= max && !EvictLongestDetached(&released)) {
    return absl::ResourceExhaustedError(
        absl::StrFormat("%d sessions are open, which is the limit", max));
  }
  const SessionDescription& description = info->description;
  if (description.resumable()) {
    id_of_token_[description.resume_token] = description.session_id;
  }
  const std::string id = description.session_id;
  entries_[id] = Entry{.info = std::move(info),
                       .session = std::move(session),
                       .stream = std::move(stream),
                       .state = AttachmentState::kAttached,
                       .since = Clock::now()};
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<Session>> SessionRegistry::Find(absl::string_view resume_token,
                                                               const Principal& principal,
                                                               absl::string_view vehicle_id) const {
  const std::lock_guard lock(mutex_);
  const auto token = id_of_token_.find(resume_token);
  if (token == id_of_token_.end()) return Gone(resume_token, "open.resume_token");
  const Entry& entry = entries_.find(token->second)->second;
  const SessionDescription& description = entry.info->description;
  if (!(description.caller.principal == principal)) {
    return absl::PermissionDeniedError("open.resume_token is of another principal's session");
  }
  if (description.vehicle_id != vehicle_id) {
    return absl::InvalidArgumentError(
        absl::StrFormat("open.vehicle_id is %s; the session of open.resume_token is %s's",
                        Quoted(vehicle_id), description.vehicle_id));
  }
  return entry.session;
}

absl::StatusOr<std::shared_ptr<SessionStream>> SessionRegistry::Attach(const SessionInfo& info,
                                                                       Stream stream) {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(info.description.session_id);
  if (found == entries_.end()) return Gone(info.description.resume_token, "open.resume_token");
  Entry& entry = found->second;
  if (Take(AttachmentEvent::kAttach, &entry) == AttachmentAction::kRefuse) {
    return absl::NotFoundError("open.resume_token: the session is being ended");
  }
  ++entry.info->resume_count;
  ++resume_count_;
  entry.info->last_activity = Clock::now();
  return std::exchange(entry.stream, std::move(stream)).lock();
}

void SessionRegistry::Detach(const SessionInfo& info, const SessionStream& stream) {
  const std::lock_guard lock(mutex_);
  Entry* entry = FindAttached(info, stream);
  if (entry == nullptr) return;
  if (Take(AttachmentEvent::kDetach, entry) != AttachmentAction::kDropStream) return;
  entry->stream.reset();
  spdlog::info("session detached session={} vehicle={}", info.description.session_id,
               info.description.vehicle_id);
}

void SessionRegistry::Remove(const SessionInfo& info, const SessionStream& stream,
                             const std::string& reason) {
  Released released;
  const std::lock_guard lock(mutex_);
  if (FindAttached(info, stream) == nullptr) return;
  Take(AttachmentEvent::kClose, entries_.find(info.description.session_id), reason, &released);
}

absl::Status SessionRegistry::End(absl::string_view session_id, absl::string_view tenant,
                                  const v1::SessionEnding& ending) {
  Released released;
  std::shared_ptr<SessionStream> stream;
  {
    const std::lock_guard lock(mutex_);
    const auto entry = FindOf(tenant, session_id);
    if (entry == entries_.end()) return Gone(session_id, "session_id");
    stream = entry->second.stream.lock();
    // A stream that is gone, and has not said so, has detached.
    if (stream == nullptr) Take(AttachmentEvent::kDetach, &entry->second);
    const AttachmentAction action = Take(AttachmentEvent::kEnd, entry, ending.message(), &released);
    if (action != AttachmentAction::kTellStream) return absl::OkStatus();
  }
  stream->Announce(ending);
  stream->End(grpc::Status(grpc::StatusCode::ABORTED, ending.message()));
  return absl::OkStatus();
}

std::vector<std::shared_ptr<Session>> SessionRegistry::SessionsIn(
    absl::string_view tenant, absl::string_view map_name) const {
  std::vector<std::shared_ptr<Session>> sessions;
  const std::lock_guard lock(mutex_);
  for (const auto& [id, entry] : entries_) {
    const SessionDescription& description = entry.info->description;
    if (description.caller.principal.tenant == tenant && description.map_name == map_name) {
      sessions.push_back(entry.session);
    }
  }
  return sessions;
}

std::optional<AttachmentEvent> SessionRegistry::DueEvent(const Entry& entry,
                                                         Clock::time_point now) const {
  // A stream that is gone, and has not said so, has detached.
  if (!IsDetached(entry.state) && entry.stream.expired()) return AttachmentEvent::kDetach;
  const auto in_state = now - entry.since;
  switch (entry.state) {
    case AttachmentState::kAttached:
      if (timeouts_.idle_timeout.count() <= 0) return std::nullopt;
      if (now - entry.info->last_activity.load() < timeouts_.idle_timeout) return std::nullopt;
      return AttachmentEvent::kEnd;
    case AttachmentState::kEnding:
      return in_state < kEndGrace ? std::nullopt : std::optional(AttachmentEvent::kOverdue);
    case AttachmentState::kDetached:
    case AttachmentState::kAbandoned:
      if (in_state < timeouts_.detached_timeout) return std::nullopt;
      return AttachmentEvent::kExpire;
    case AttachmentState::kEnded:
      break;
  }
  return std::nullopt;
}

void SessionRegistry::Reap(Clock::time_point now) {
  const std::string expired =
      absl::StrCat("it was without a stream for more than ", Text(timeouts_.detached_timeout));
  std::vector<SessionDescription> idle;
  std::vector<std::shared_ptr<SessionStream>> overdue;
  Released released;
  {
    const std::lock_guard lock(mutex_);
    for (auto entry = entries_.begin(); entry != entries_.end();) {
      const auto current = entry++;
      const std::optional<AttachmentEvent> event = DueEvent(current->second, now);
      if (!event) continue;
      if (*event == AttachmentEvent::kEnd) {
        idle.push_back(current->second.info->description);
        continue;
      }
      auto stream = current->second.stream.lock();
      const AttachmentAction action = Take(*event, current, expired, &released);
      if (action == AttachmentAction::kAbortStream && stream != nullptr) {
        overdue.push_back(std::move(stream));
      }
    }
  }
  for (const auto& stream : overdue) stream->Abort();
  v1::SessionEnding ending;
  ending.set_reason(v1::SESSION_END_REASON_IDLE);
  ending.set_message(absl::StrCat("no scan came for ", Text(timeouts_.idle_timeout)));
  for (const SessionDescription& session : idle) {
    // One that has just ended by itself is not found, which is as well.
    End(session.session_id, session.caller.principal.tenant, ending).IgnoreError();
  }
}

void SessionRegistry::RemoveDetached(const std::string& reason) {
  Released released;
  const std::lock_guard lock(mutex_);
  for (auto entry = entries_.begin(); entry != entries_.end();) {
    Take(AttachmentEvent::kDrain, entry++, reason, &released);
  }
}

std::vector<ListedSession> SessionRegistry::List(absl::string_view tenant,
                                                 absl::string_view after_id, int limit) const {
  std::vector<ListedSession> list;
  const std::lock_guard lock(mutex_);
  for (auto entry = entries_.upper_bound(after_id);
       entry != entries_.end() && static_cast<int>(list.size()) < limit; ++entry) {
    const Entry& session = entry->second;
    if (session.info->description.caller.principal.tenant != tenant) continue;
    list.push_back({session.info, IsDetached(session.state)});
  }
  return list;
}

absl::StatusOr<ListedSession> SessionRegistry::Get(absl::string_view tenant,
                                                   absl::string_view session_id) {
  const std::lock_guard lock(mutex_);
  const auto entry = FindOf(tenant, session_id);
  if (entry == entries_.end()) return Gone(session_id, "session_id");
  return ListedSession{entry->second.info, IsDetached(entry->second.state)};
}

absl::StatusOr<std::shared_ptr<Session>> SessionRegistry::GetSession(absl::string_view tenant,
                                                                     absl::string_view session_id) {
  const std::lock_guard lock(mutex_);
  const auto entry = FindOf(tenant, session_id);
  if (entry == entries_.end()) return Gone(session_id, "session_id");
  return entry->second.session;
}

SessionRegistry::Entries::iterator SessionRegistry::FindOf(absl::string_view tenant,
                                                           absl::string_view session_id) {
  const auto entry = entries_.find(session_id);
  const bool found =
      entry != entries_.end() && entry->second.info->description.caller.principal.tenant == tenant;
  return found ? entry : entries_.end();
}

std::vector<std::shared_ptr<SessionInfo>> SessionRegistry::All() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::shared_ptr<SessionInfo>> infos;
  infos.reserve(entries_.size());
  for (const auto& [session_id, entry] : entries_) infos.push_back(entry.info);
  return infos;
}

int SessionRegistry::count() const {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(entries_.size());
}

SessionCensus SessionRegistry::Census() const {
  SessionCensus census;
  const std::lock_guard lock(mutex_);
  for (const auto& [id, entry] : entries_) {
    const int state = entry.info->last_state + 1;
    ++(IsDetached(entry.state) ? census.detached
                               : census.attached)[static_cast<std::size_t>(state)];
  }
  return census;
}

int SessionRegistry::detached_count() const {
  const std::lock_guard lock(mutex_);
  int count = 0;
  for (const auto& [id, entry] : entries_) count += IsDetached(entry.state) ? 1 : 0;
  return count;
}

std::int64_t SessionRegistry::resume_count() const {
  const std::lock_guard lock(mutex_);
  return resume_count_;
}

AttachmentAction SessionRegistry::Take(AttachmentEvent event, Entry* entry) {
  const AttachmentTransition transition = Next(entry->state, event);
  if (transition.state != entry->state) entry->since = Clock::now();
  entry->state = transition.state;
  return transition.action;
}

AttachmentAction SessionRegistry::Take(AttachmentEvent event, Entries::iterator entry,
                                       const std::string& reason, Released* released) {
  const AttachmentAction action = Take(event, &entry->second);
  if (action == AttachmentAction::kRelease) Release(entry, reason, released);
  return action;
}

SessionRegistry::Entry* SessionRegistry::FindAttached(const SessionInfo& info,
                                                      const SessionStream& stream) {
  const auto entry = entries_.find(info.description.session_id);
  const bool found = entry != entries_.end() && IsAttachedTo(entry->second.stream, stream);
  return found ? &entry->second : nullptr;
}

void SessionRegistry::Release(Entries::iterator entry, const std::string& reason,
                              Released* released) {
  const SessionDescription& description = entry->second.info->description;
  WithinMemory([&] {
    spdlog::info("session released session={} vehicle={} reason={}", description.session_id,
                 description.vehicle_id, Quoted(reason));
    Remember(description, reason);
  }).IgnoreError();  // it goes all the same
  id_of_token_.erase(description.resume_token);
  WithinMemory([&] { released->push_back(std::move(entry->second)); }).IgnoreError();
  entries_.erase(entry);
}

bool SessionRegistry::EvictLongestDetached(Released* released) {
  auto longest = entries_.end();
  for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
    if (!IsDetached(entry->second.state)) continue;
    if (longest == entries_.end() || entry->second.since < longest->second.since) longest = entry;
  }
  if (longest == entries_.end()) return false;
  Take(AttachmentEvent::kEvict, longest, "it was without a stream when others needed the place",
       released);
  return true;
}

void SessionRegistry::Remember(const SessionDescription& description, const std::string& reason) {
  for (const std::string& key : {description.session_id, description.resume_token}) {
    if (key.empty()) continue;
    end_reasons_[key] = reason;
    remembered_.push_back(key);
  }
  while (remembered_.size() > kMaxRemembered) {
    end_reasons_.erase(remembered_.front());
    remembered_.pop_front();
  }
}

absl::Status SessionRegistry::Gone(absl::string_view key, absl::string_view what) const {
  const auto reason = end_reasons_.find(key);
  return absl::NotFoundError(
      reason == end_reasons_.end()
          ? absl::StrCat(what, ": there is no such session; the server may have been restarted")
          : absl::StrCat(what, ": the session has ended: ", reason->second));
}

}  // namespace dcloc::server
