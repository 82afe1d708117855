#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "client/ros/node_messages.h"
#include "client/ros/topic_intake.h"
#include "client/ros/vehicle_link.h"
#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::node {

/// What is counted of the node's work.
struct NodeCounts {
  std::int64_t sent = 0;
  std::int64_t answered = 0;
  std::int64_t rejected = 0;        ///< by the server
  std::int64_t dropped = 0;         ///< not sent: the queue was full, or there was no session
  std::int64_t dropped_before = 0;  ///< of TopicIntake
  std::int64_t clock_jumps = 0;
  std::int64_t fixes_sent = 0;
  std::int64_t fixes_fused = 0;
  std::int64_t fixes_refused = 0;
};

/// What diagnostics are made of.
struct NodeState {
  LinkStatus link;
  NodeCounts counts;
  std::optional<v1::LocalizationResult> newest;
  std::optional<std::chrono::steady_clock::time_point> newest_at;
  std::string last_rejection;
};

/// State and protection level, health of the sources, and the topics: three entries.
std::vector<Diagnostic> DiagnosticsOf(const NodeState& state,
                                      const std::map<std::string, TopicState>& topics,
                                      std::chrono::steady_clock::time_point now);

}  // namespace dcloc::node
