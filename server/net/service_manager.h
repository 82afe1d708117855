#pragma once

#include <chrono>
#include <optional>

#include "absl/strings/string_view.h"

namespace dcloc::server {

/// Notifies systemd of the program's state ("READY=1", "WATCHDOG=1", "STOPPING=1"; see
/// sd_notify(3)). Does nothing if the program was not started by systemd. False if the notification
/// failed.
bool NotifyServiceManager(absl::string_view state);

/// How often systemd wants to hear "WATCHDOG=1"; nothing where it does not.
std::optional<std::chrono::microseconds> WatchdogInterval();

}  // namespace dcloc::server
