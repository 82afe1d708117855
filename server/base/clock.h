#pragma once

#include <chrono>

namespace dcloc::server {

/// Wall-clock time as it is stored and sent: nanoseconds since the Unix epoch, UTC.
using SystemTime = std::chrono::sys_time<std::chrono::nanoseconds>;

}  // namespace dcloc::server
