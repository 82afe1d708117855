#include "client/ros/diagnostics.h"

#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/strip.h"

namespace dcloc::node {
namespace {

using Level = Diagnostic::Level;
using Time = std::chrono::steady_clock::time_point;

/// A topic or an answer is missing when nothing came for so long.
constexpr double kSilentAfter_s = 1.0;

double SecondsSince(const std::optional<Time>& then, Time now) {
  return then ? std::chrono::duration<double>(now - *then).count() : -1.0;
}

bool IsSilent(const std::optional<Time>& newest, Time now) {
  return !newest || SecondsSince(newest, now) > kSilentAfter_s;
}

std::string Age(const std::optional<Time>& then, Time now) {
  return then ? absl::StrFormat("%.1f", SecondsSince(then, now)) : "never";
}

/// "dead_reckoning" of LOCALIZATION_STATE_DEAD_RECKONING.
std::string Shortened(std::string name, const char* prefix) {
  return absl::AsciiStrToLower(absl::StripPrefix(name, prefix));
}

const char* PhaseText(LinkStatus::Phase phase) {
  switch (phase) {
    case LinkStatus::Phase::kWaiting:
      return "waiting for the radars";
    case LinkStatus::Phase::kConnecting:
      return "connecting";
    case LinkStatus::Phase::kOpen:
      return "open";
    case LinkStatus::Phase::kReconnecting:
      return "reconnecting";
  }
  return "";
}

Level LevelOf(v1::LocalizationState state) {
  if (state == v1::LOCALIZATION_STATE_TRACKING) return Level::kOk;
  return state == v1::LOCALIZATION_STATE_LOST ? Level::kError : Level::kWarn;
}

Diagnostic StateOf(const NodeState& state, Time now) {
  Diagnostic entry{.name = "dcloc: state"};
  const bool is_open = state.link.phase == LinkStatus::Phase::kOpen;
  const bool has_answer = state.newest && !IsSilent(state.newest_at, now);
  if (is_open && has_answer) {
    entry.level = LevelOf(state.newest->state());
    entry.message =
        Shortened(v1::LocalizationState_Name(state.newest->state()), "LOCALIZATION_STATE_");
  } else {
    entry.level = Level::kError;
    entry.message = is_open ? "no answers" : PhaseText(state.link.phase);
    if (!state.link.text.empty()) absl::StrAppend(&entry.message, ": ", state.link.text);
  }
  const bool has_level = has_answer && state.newest->has_protection_level_m();
  const NodeCounts& counts = state.counts;
  entry.values = {
      {"protection_level_m",
       has_level ? absl::StrFormat("%.2f", state.newest->protection_level_m()) : "none"},
      {"connection", PhaseText(state.link.phase)},
      {"session", state.link.session_id},
      {"map_version", absl::StrCat(state.link.map_version)},
      {"sessions_opened", absl::StrCat(state.link.session_count)},
      {"disconnects", absl::StrCat(state.link.disconnect_count)},
      {"resets", absl::StrCat(state.newest ? state.newest->resets().count() : 0)},
      {"scans_sent", absl::StrCat(counts.sent)},
      {"scans_answered", absl::StrCat(counts.answered)},
      {"scans_rejected", absl::StrCat(counts.rejected)},
      {"scans_dropped", absl::StrCat(counts.dropped + counts.dropped_before)},
      {"last_rejection", state.last_rejection},
      {"clock_jumps", absl::StrCat(counts.clock_jumps)},
      {"fixes_sent", absl::StrCat(counts.fixes_sent)},
      {"fixes_fused", absl::StrCat(counts.fixes_fused)},
      {"fixes_refused", absl::StrCat(counts.fixes_refused)}};
  return entry;
}

Diagnostic SourcesOf(const NodeState& state) {
  Diagnostic entry{.name = "dcloc: sources", .message = "all are used"};
  if (!state.newest) {
    entry.level = Level::kWarn;
    entry.message = "nothing is known yet";
    return entry;
  }
  std::vector<std::string> unused;
  const auto add = [&](const std::string& name, const auto& health) {
    const std::string fault = Shortened(v1::SourceFault_Name(health.fault()), "SOURCE_FAULT_");
    entry.values.emplace_back(name, absl::StrCat(health.used() ? "used, " : "not used, ", fault));
    if (!health.used()) unused.push_back(absl::StrCat(name, " (", fault, ")"));
  };
  const v1::Health& health = state.newest->health();
  add("wheel_speed", health.wheel_speed());
  add("yaw_rate", health.yaw_rate());
  for (const v1::RadarHealth& radar : health.radars()) add(radar.radar_id(), radar);
  if (unused.empty()) return entry;
  entry.level = Level::kWarn;
  entry.message = absl::StrCat("not used: ", absl::StrJoin(unused, ", "));
  return entry;
}

Diagnostic TopicsOf(const std::map<std::string, TopicState>& topics, Time now) {
  Diagnostic entry{.name = "dcloc: topics", .message = "all come"};
  std::vector<std::string> faults;
  for (const auto& [topic, state] : topics) {
    const bool is_static = topic == "/tf_static";
    const bool is_silent = !is_static && IsSilent(state.newest, now);
    entry.values.emplace_back(topic,
                              absl::StrCat(state.message_count, " messages, ", state.error_count,
                                           " unusable, age ", Age(state.newest, now), " s"));
    if (!state.error.empty()) {
      entry.level = Level::kError;
      faults.push_back(state.error);
    } else if (is_silent) {
      entry.level = std::max(entry.level, Level::kWarn);
      faults.push_back(absl::StrCat("topic ", topic, ": nothing comes"));
    }
  }
  if (!faults.empty()) entry.message = absl::StrJoin(faults, "; ");
  return entry;
}

}  // namespace

std::vector<Diagnostic> DiagnosticsOf(const NodeState& state,
                                      const std::map<std::string, TopicState>& topics, Time now) {
  return {StateOf(state, now), SourcesOf(state), TopicsOf(topics, now)};
}

}  // namespace dcloc::node
