#include "client/rosbag/transform_tree.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <iterator>
#include <utility>

namespace dcloc::rosbag {
namespace {

constexpr std::chrono::nanoseconds kMaxGap = std::chrono::seconds(1);
constexpr std::size_t kMaxDepth = 100;  ///< a chain longer than this goes round in a circle

}  // namespace

void TransformTree::Add(const Transform& transform, bool is_static) {
  Edge& edge = edges_[transform.child];
  edge.parent = transform.parent;
  edge.is_static = is_static;
  if (is_static) edge.samples.clear();  // the last one holds
  edge.samples.push_back({transform.stamp, transform.T_parent_child});
}

void TransformTree::Sort() {
  for (auto& [child, edge] : edges_) {
    std::ranges::stable_sort(edge.samples, {}, &Sample::stamp);
  }
}

std::pair<std::string, Pose3> TransformTree::StaticRoot(const std::string& child) const {
  std::pair<std::string, Pose3> root{child, Pose3()};
  for (std::size_t depth = 0; depth < kMaxDepth; ++depth) {
    const auto edge = edges_.find(root.first);
    if (edge == edges_.end() || !edge->second.is_static) break;
    // The first step as it is, to the bit.
    const Pose3& T_parent_frame = edge->second.samples.front().T_parent_child;
    root = {edge->second.parent, depth == 0 ? T_parent_frame : T_parent_frame * root.second};
  }
  return root;
}

std::optional<Pose3> TransformTree::Static(const std::string& parent,
                                           const std::string& child) const {
  if (parent == child) return Pose3();
  if (const auto edge = edges_.find(child);
      edge != edges_.end() && edge->second.is_static && edge->second.parent == parent) {
    return edge->second.samples.front().T_parent_child;
  }
  const auto [parent_root, T_root_parent] = StaticRoot(parent);
  const auto [child_root, T_root_child] = StaticRoot(child);
  if (parent_root != child_root) return std::nullopt;
  return T_root_parent.Inverse() * T_root_child;
}

std::optional<Pose3> TransformTree::Interpolate(const Edge& edge, Stamp stamp) {
  if (edge.is_static) return edge.samples.front().T_parent_child;
  const auto after = std::ranges::lower_bound(edge.samples, stamp, {}, &Sample::stamp);
  if (after == edge.samples.end()) return std::nullopt;
  if (after->stamp == stamp) return after->T_parent_child;
  if (after == edge.samples.begin()) return std::nullopt;
  const Sample& before = *std::prev(after);
  const std::chrono::nanoseconds gap = after->stamp - before.stamp;
  if (gap > kMaxGap) return std::nullopt;
  const double share =
      static_cast<double>((stamp - before.stamp).count()) / static_cast<double>(gap.count());
  const Vector6d step = Log(before.T_parent_child.Inverse() * after->T_parent_child);
  return before.T_parent_child * Exp(Vector6d(share * step));
}

std::optional<Pose3> TransformTree::At(const std::string& ancestor, const std::string& child,
                                       Stamp stamp) const {
  std::optional<Pose3> T_frame_child;
  std::string frame = child;
  for (std::size_t depth = 0; depth < kMaxDepth && frame != ancestor; ++depth) {
    const auto edge = edges_.find(frame);
    if (edge == edges_.end()) return std::nullopt;
    const std::optional<Pose3> T_parent_frame = Interpolate(edge->second, stamp);
    if (!T_parent_frame) return std::nullopt;
    T_frame_child = T_frame_child ? *T_parent_frame * *T_frame_child : *T_parent_frame;
    frame = edge->second.parent;
  }
  if (frame != ancestor) return std::nullopt;
  return T_frame_child ? T_frame_child : Pose3();
}

}  // namespace dcloc::rosbag
