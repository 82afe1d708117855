#pragma once

#include <list>
#include <map>
#include <optional>
#include <string>

namespace dcloc::server {

class LocalizeStream;

/// The streams whose first message has not come. They are bounded, in all and for each group (a
/// peer's address, or a principal once it is known): whoever sends nothing can only crowd out
/// others that send nothing. Not thread-safe.
class UnopenedStreams {
 public:
  struct Bounds {
    int total = 0;
    int group = 0;  ///< 0: only the total counts
  };

  /// A stream that has to go, and why.
  struct Excess {
    LocalizeStream* stream = nullptr;
    std::string reason;
  };

  /// Adds a stream. If there are too many now: the oldest of its group, or else the oldest of the
  /// largest group, which is forgotten here.
  std::optional<Excess> Add(LocalizeStream* stream, const std::string& group, const Bounds& bounds);

  /// Puts a stream, if it is here, into another group; as in `Add`.
  std::optional<Excess> Move(LocalizeStream* stream, const std::string& group,
                             const Bounds& bounds);

  /// Does nothing if it is not here.
  void Remove(LocalizeStream* stream);

  int count() const { return static_cast<int>(place_of_.size()); }

 private:
  using Group = std::list<LocalizeStream*>;  // the oldest first
  using Groups = std::map<std::string, Group>;
  struct Place {
    Groups::iterator group;
    Group::iterator position;
  };

  Excess TakeOldest(Groups::iterator group, int max, const char* setting);

  Groups groups_;
  std::map<LocalizeStream*, Place> place_of_;
};

}  // namespace dcloc::server
