#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "absl/status/statusor.h"
#include "server/postgres/postgres_error.h"
#include "server/postgres/postgres_watch.h"

namespace dcloc::server {

struct QueryCacheOptions {
  std::size_t max_count = 10'000;  ///< of answers; beyond it all are forgotten
  /// How long after it was known to hold an answer is given while the database is away; none: for
  /// good.
  std::optional<std::chrono::nanoseconds> max_away;
};

/// The last answers of a database to one kind of question. An answer is given again without asking
/// while it is certain that nothing has changed; so another server's change is seen within
/// `kMaxChangeDelay`, and one by this process at once (`Forget`). While the database is away, what
/// was known last is given. Errors are not kept. Thread-safe.
template <typename Question, typename Answer>
class QueryCache {
 public:
  /// `watch` outlives it.
  QueryCache(const PostgresWatch& watch, ChangeTopic topic, const QueryCacheOptions& options)
      : watch_(watch), topic_(topic), options_(options) {}

  /// The answer to `question`, for which `ask()` asks the database.
  template <typename Ask>
  absl::StatusOr<Answer> Get(const Question& question, const Ask& ask) {
    const ChangeState changes = watch_.state(topic_);  // before asking
    std::int64_t round = 0;
    {
      const std::lock_guard lock(mutex_);
      round = round_;
      const auto known = entries_.find(question);
      if (known != entries_.end() && changes.fresh && IsCurrent(known->second, changes)) {
        return known->second.answer;
      }
    }
    const auto now = Clock::now();
    absl::StatusOr<Answer> answer = ask();
    const std::lock_guard lock(mutex_);
    if (answer.ok()) {
      if (entries_.size() >= options_.max_count) entries_.clear();
      entries_.insert_or_assign(question, Entry{*answer, changes.number, round, now});
    } else if (!IsAway(answer.status())) {
      entries_.erase(question);
    } else if (const auto known = entries_.find(question); known != entries_.end()) {
      if (MayBeGiven(known->second, changes, now)) return known->second.answer;
    }
    return answer;
  }

  /// This process has changed something.
  void Forget() {
    const std::lock_guard lock(mutex_);
    ++round_;
  }

 private:
  using Clock = std::chrono::steady_clock;

  struct Entry {
    Answer answer;
    std::int64_t change_number = 0;  ///< of the last change when it was asked
    std::int64_t round = 0;
    Clock::time_point ask_time;
  };

  bool IsCurrent(const Entry& entry, const ChangeState& changes) const {
    return entry.change_number == changes.number && entry.round == round_;
  }

  bool MayBeGiven(const Entry& entry, const ChangeState& changes, Clock::time_point now) const {
    if (!options_.max_away) return true;
    // As long as nothing changed it held, also long after it was asked.
    const auto hold_time = IsCurrent(entry, changes) ? changes.confirm_time : entry.ask_time;
    return now - hold_time <= *options_.max_away;
  }

  const PostgresWatch& watch_;
  const ChangeTopic topic_;
  const QueryCacheOptions options_;
  std::mutex mutex_;
  std::map<Question, Entry> entries_;
  std::int64_t round_ = 0;  ///< raised by each own change
};

}  // namespace dcloc::server
