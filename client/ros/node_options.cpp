#include "client/ros/node_options.h"

#include <array>
#include <type_traits>
#include <utility>

#include "absl/strings/str_cat.h"

namespace dcloc::node {
namespace {

template <typename Value>
struct Parameter {
  const char* name;
  Value NodeOptions::*member;
};

/// A number with its bounds.
struct Number {
  const char* name;
  double NodeOptions::*member;
  double min;
  double max;
};

constexpr Parameter<std::string> kTexts[] = {
    {"server", &NodeOptions::server},
    {"map", &NodeOptions::map},
    {"vehicle", &NodeOptions::vehicle},
    {"mapping", &NodeOptions::mapping},
    {"rig", &NodeOptions::rig},
    {"odom_frame", &NodeOptions::odom_frame},
    {"initial_pose_topic", &NodeOptions::initial_pose_topic},
    {"fix_topic", &NodeOptions::fix_topic},
    {"tls_ca", &NodeOptions::tls_ca},
    {"tls_cert", &NodeOptions::tls_cert},
    {"tls_key", &NodeOptions::tls_key},
    {"token_file", &NodeOptions::token_file}};

constexpr Parameter<bool> kFlags[] = {{"publish_tf", &NodeOptions::publish_tf}};

constexpr Number kNumbers[] = {
    {"odometry_rate_hz", &NodeOptions::odometry_rate_hz, 0.0, 1000.0},
    {"max_velocity_wait_s", &NodeOptions::max_velocity_wait_s, 0.0, 0.2},
    {"radar_wait_s", &NodeOptions::radar_wait_s, 0.0, 3600.0},
    {"fix_sigma_m", &NodeOptions::fix_sigma_m, 0.01, 1000.0},
    {"max_queued_scan_count", &NodeOptions::max_queued_scan_count, 1.0, 10000.0},
    {"reconnect_give_up_s", &NodeOptions::reconnect_give_up_s, 1.0, 1e6}};

/// As it would be written.
std::string TextOf(const ParameterValue& value) {
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  if (const auto* number = std::get_if<double>(&value)) return absl::StrCat(*number);
  return absl::StrCat("\"", std::get<std::string>(value), "\"");
}

/// True when `name` is one of `known`, whose value is then taken.
template <typename Known>
absl::StatusOr<bool> TakeOne(const Known& known, const char* wanted, const std::string& name,
                             const ParameterValue& value, NodeOptions& options) {
  for (const auto& parameter : known) {
    if (name != parameter.name) continue;
    using Value = std::remove_reference_t<decltype(options.*parameter.member)>;
    const Value* const taken = std::get_if<Value>(&value);
    if (taken == nullptr) {
      return absl::InvalidArgumentError(
          absl::StrCat("~", name, " is ", TextOf(value), "; it must be ", wanted));
    }
    options.*parameter.member = *taken;
    return true;
  }
  return false;
}

absl::Status Take(const std::string& name, const ParameterValue& value, NodeOptions& options) {
  absl::StatusOr<bool> taken = TakeOne(kTexts, "a text", name, value, options);
  if (taken.ok() && !*taken) taken = TakeOne(kFlags, "true or false", name, value, options);
  if (taken.ok() && !*taken) taken = TakeOne(kNumbers, "a number", name, value, options);
  if (!taken.ok()) return taken.status();
  if (*taken) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("~", name, " is no parameter of this node"));
}

}  // namespace

absl::StatusOr<NodeOptions> OptionsOf(const std::map<std::string, ParameterValue>& parameters) {
  NodeOptions options;
  for (const auto& [name, value] : parameters) {
    if (absl::Status status = Take(name, value, options); !status.ok()) return status;
  }
  if (absl::Status status = Validate(options); !status.ok()) return status;
  return options;
}

absl::Status Validate(const NodeOptions& options) {
  const std::pair<const char*, const std::string&> needed[] = {{"server", options.server},
                                                               {"map", options.map},
                                                               {"vehicle", options.vehicle},
                                                               {"mapping", options.mapping},
                                                               {"odom_frame", options.odom_frame}};
  for (const auto& [name, text] : needed) {
    if (!text.empty()) continue;
    return absl::InvalidArgumentError(absl::StrCat("~", name, " is empty; it must be given"));
  }
  for (const Number& number : kNumbers) {
    const double value = options.*number.member;
    if (value >= number.min && value <= number.max) continue;
    return absl::InvalidArgumentError(absl::StrCat(
        "~", number.name, " is ", value, "; it must lie in [", number.min, ", ", number.max, "]"));
  }
  return absl::OkStatus();
}

}  // namespace dcloc::node
