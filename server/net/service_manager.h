#pragma once

#include <chrono>
#include <optional>

#include "absl/strings/string_view.h"

namespace dcloc::server {

/// Tells systemd how the program does ("READY=1", "WATCHDOG=1", "STOPPING=1"; see sd_notify(3)).
/// Nothing where it was not started by systemd. False when it could not be told.
bool NotifyServiceManager(absl::string_view state);

/// How often systemd wants to hear "WATCHDOG=1"; nothing where it does not.
std::optional<std::chrono::microseconds> WatchdogInterval();

}  // namespace dcloc::server
