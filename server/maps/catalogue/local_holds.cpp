#include "server/maps/catalogue/local_holds.h"

#include <limits>
#include <map>
#include <mutex>
#include <utility>

#include "absl/strings/str_cat.h"

namespace dcloc::server {

struct LocalHolds::State {
  using Key = std::pair<std::string, std::int64_t>;

  std::mutex mutex;
  std::map<Key, int> version_counts;         ///< held ones only
  std::map<std::string, std::string> files;  ///< each held file's holder

  void GiveBackVersion(const Key& key) {
    const std::lock_guard lock(mutex);
    const auto entry = version_counts.find(key);
    if (--entry->second == 0) version_counts.erase(entry);
  }

  void GiveBackFile(const std::string& sha256) {
    const std::lock_guard lock(mutex);
    files.erase(sha256);
  }
};

LocalHolds::LocalHolds() : state_(std::make_shared<State>()) {}

Hold LocalHolds::HoldVersion(absl::string_view map_name, std::int64_t version) {
  State::Key key(map_name, version);
  {
    const std::lock_guard lock(state_->mutex);
    ++state_->version_counts[key];
  }
  return Hold([state = state_, key = std::move(key)] { state->GiveBackVersion(key); });
}

absl::StatusOr<Hold> LocalHolds::HoldFile(absl::string_view sha256, absl::string_view holder) {
  std::string file(sha256);
  {
    const std::lock_guard lock(state_->mutex);
    const auto [entry, added] = state_->files.try_emplace(file, holder);
    if (!added) {
      return absl::UnavailableError(absl::StrCat("file ", sha256, " is being stored or removed by ",
                                                 entry->second, "; try again"));
    }
  }
  return Hold([state = state_, file = std::move(file)] { state->GiveBackFile(file); });
}

bool LocalHolds::IsHeld(absl::string_view map_name, std::int64_t version) const {
  const std::lock_guard lock(state_->mutex);
  return state_->version_counts.contains(State::Key(map_name, version));
}

std::optional<std::int64_t> LocalHolds::NewestHeld(absl::string_view map_name) const {
  const std::lock_guard lock(state_->mutex);
  const State::Key above(map_name, std::numeric_limits<std::int64_t>::max());
  const auto next = state_->version_counts.upper_bound(above);
  if (next == state_->version_counts.begin()) return std::nullopt;
  const auto& [name, version] = std::prev(next)->first;
  return name == map_name ? std::optional(version) : std::nullopt;
}

}  // namespace dcloc::server
