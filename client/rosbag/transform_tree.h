#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "client/rosbag/messages.h"
#include "core/geometry/pose.h"
#include "core/radar/stamp.h"

namespace dcloc::rosbag {

/// Frames in their parents over time, as TF tells them.
class TransformTree {
 public:
  void Add(const Transform& transform, bool is_static);

  /// To be called after the last `Add`.
  void Sort();

  /// T_parent_child by transforms that never change; absent where no chain of them joins the two.
  std::optional<Pose3> Static(const std::string& parent, const std::string& child) const;

  /// T_ancestor_child at `stamp`, each transform between its samples; a sample at the very stamp is
  /// given as it is. Absent where a chain is missing, or has no samples around the stamp within a
  /// second.
  std::optional<Pose3> At(const std::string& ancestor, const std::string& child, Stamp stamp) const;

 private:
  struct Sample {
    Stamp stamp;
    Pose3 T_parent_child;
  };
  struct Edge {
    std::string parent;
    bool is_static = false;
    std::vector<Sample> samples;
  };

  static std::optional<Pose3> Interpolate(const Edge& edge, Stamp stamp);
  /// T_root_child and the root, by static transforms alone.
  std::pair<std::string, Pose3> StaticRoot(const std::string& child) const;

  std::map<std::string, Edge> edges_;  ///< by child
};

}  // namespace dcloc::rosbag
