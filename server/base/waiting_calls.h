#pragma once

#include <algorithm>
#include <list>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/str_format.h"
#include "server/base/status.h"

namespace dcloc::server {

/// A peer as the transport names it, "ipv4:192.0.2.1:5000", without its port.
inline std::string AddressOf(const std::string& peer) { return peer.substr(0, peer.rfind(':')); }

/// How many calls may wait for their peers.
struct WaitingBounds {
  int total = 0;
  int group = 0;  ///< 0: only the total counts
};

/// Calls that wait, such as those whose first message has not come. They are bounded, in all and
/// for each group (a peer's address, or a principal once it is known): whoever sends nothing can
/// only crowd out others that send nothing. Calls are only told apart here. Not thread-safe.
template <typename Call>
class WaitingCalls {
 public:
  /// `what` they do, for the reasons.
  explicit WaitingCalls(std::string what = "wait for their first message")
      : what_(std::move(what)) {}

  /// A call that has to go, and why.
  struct Excess {
    Call* call = nullptr;
    std::string reason;
  };

  /// Adds a call. If there are too many now: the oldest of its group, or else the oldest of the
  /// largest group, which is forgotten here.
  std::optional<Excess> Add(Call* call, const std::string& group, const WaitingBounds& bounds) {
    const auto own = groups_.try_emplace(group).first;
    Group one = {call};
    place_of_[call] = {own, one.begin()};
    own->second.splice(own->second.end(), one);  // last, as it cannot fail
    if (bounds.group > 0 && static_cast<int>(own->second.size()) > bounds.group) {
      return TakeOldest(own, bounds.group, "max_unopened_stream_count_per_peer");
    }
    if (count() <= bounds.total) return std::nullopt;
    const auto largest = std::ranges::max_element(
        groups_, {}, [](const typename Groups::value_type& entry) { return entry.second.size(); });
    return TakeOldest(largest, bounds.total, "max_unopened_stream_count");
  }

  /// Puts a call, if it is here, into another group; as in `Add`.
  std::optional<Excess> Move(Call* call, const std::string& group, const WaitingBounds& bounds) {
    if (!Remove(call)) return std::nullopt;
    return Add(call, group, bounds);
  }

  /// Whether it was here.
  bool Remove(Call* call) {
    const auto found = place_of_.find(call);
    if (found == place_of_.end()) return false;
    const Place place = found->second;
    place_of_.erase(found);
    place.group->second.erase(place.position);
    if (place.group->second.empty()) groups_.erase(place.group);
    return true;
  }

  int count() const { return static_cast<int>(place_of_.size()); }

 private:
  using Group = std::list<Call*>;  // the oldest first
  using Groups = std::map<std::string, Group>;
  struct Place {
    typename Groups::iterator group;
    typename Group::iterator position;
  };

  Excess TakeOldest(typename Groups::iterator group, int max, const char* setting) {
    Excess excess{.call = group->second.front(),
                  .reason = absl::StrFormat("%d calls of %s %s; %s is %d", group->second.size(),
                                            Quoted(group->first), what_, setting, max)};
    Remove(excess.call);
    return excess;
  }

  std::string what_;
  Groups groups_;
  std::map<Call*, Place> place_of_;
};

}  // namespace dcloc::server
