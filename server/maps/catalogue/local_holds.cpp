#include "server/maps/catalogue/local_holds.h"

#include <limits>
#include <map>
#include <mutex>
#include <set>
#include <utility>

#include "absl/functional/any_invocable.h"
#include "server/maps/catalogue/catalogue_errors.h"

namespace dcloc::server {
namespace {

constexpr std::int64_t kAllVersions = std::numeric_limits<std::int64_t>::max();

}  // namespace

// What gives a hold back is made before anything is held: without memory for it nothing is.
using GiveBack = absl::AnyInvocable<void()>;

struct LocalHolds::State {
  using Key = std::pair<std::string, std::int64_t>;

  std::mutex mutex;
  std::map<Key, int> version_counts;         ///< held ones only
  std::set<Key> barred;                      ///< kAllVersions for a whole map
  std::map<std::string, std::string> files;  ///< each held file's holder

  bool IsBarred(const Key& key) const {
    return barred.contains(key) || barred.contains(Key(key.first, kAllVersions));
  }

  /// The newest version of a map that is held; 0: none.
  std::int64_t NewestHeld(const std::string& map_name) const {
    const auto next = version_counts.upper_bound(Key(map_name, kAllVersions));
    if (next == version_counts.begin()) return 0;
    const auto& [name, version] = std::prev(next)->first;
    return name == map_name ? version : 0;
  }

  void GiveBackVersion(const Key& key) {
    const std::lock_guard lock(mutex);
    const auto entry = version_counts.find(key);
    if (--entry->second == 0) version_counts.erase(entry);
  }

  void GiveBackFile(const std::string& sha256) {
    const std::lock_guard lock(mutex);
    files.erase(sha256);
  }

  void Unbar(const Key& key) {
    const std::lock_guard lock(mutex);
    barred.erase(key);
  }

  /// With the mutex held.
  static Hold Bar(const std::shared_ptr<State>& state, const Key& key) {
    GiveBack unbar = [state, key] { state->Unbar(key); };
    state->barred.insert(key);
    return Hold(std::move(unbar));
  }
};

LocalHolds::LocalHolds() : state_(std::make_shared<State>()) {}

absl::StatusOr<Hold> LocalHolds::HoldVersion(absl::string_view map_name, std::int64_t version) {
  const State::Key key(map_name, version);
  GiveBack give_back = [state = state_, key] { state->GiveBackVersion(key); };
  {
    const std::lock_guard lock(state_->mutex);
    if (state_->IsBarred(key)) return VersionBeingDeleted(map_name);
    ++state_->version_counts[key];
  }
  return Hold(std::move(give_back));
}

absl::StatusOr<Hold> LocalHolds::HoldFile(absl::string_view sha256, absl::string_view holder) {
  const std::string file(sha256);
  GiveBack give_back = [state = state_, file] { state->GiveBackFile(file); };
  {
    const std::lock_guard lock(state_->mutex);
    const auto [entry, added] = state_->files.try_emplace(file, holder);
    if (!added) return FileHeld(sha256, entry->second);
  }
  return Hold(std::move(give_back));
}

absl::StatusOr<Hold> LocalHolds::BarVersion(absl::string_view map_name, std::int64_t version) {
  const State::Key key(map_name, version);
  const std::lock_guard lock(state_->mutex);
  if (state_->version_counts.contains(key)) return VersionInUse(map_name, version);
  if (state_->IsBarred(key)) return VersionBeingDeleted(map_name);
  return State::Bar(state_, key);
}

absl::StatusOr<Hold> LocalHolds::BarMap(absl::string_view map_name) {
  const State::Key key(map_name, kAllVersions);
  const std::lock_guard lock(state_->mutex);
  const std::int64_t version = state_->NewestHeld(key.first);
  if (version != 0) return VersionInUse(map_name, version);
  if (state_->IsBarred(key)) return VersionBeingDeleted(map_name);
  return State::Bar(state_, key);
}

}  // namespace dcloc::server
