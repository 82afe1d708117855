#pragma once

#include <cstddef>
#include <memory>

#include "spdlog/sinks/sink.h"

namespace dcloc::server {

/// Passes lines to `sink` on a thread of its own, so that logging never waits for a disk or for the
/// reader of a pipe. At most `max_line_count` lines wait; beyond that the oldest are dropped, and a
/// line says how many. `flush` and the destructor wait for the queued lines, but at most a second.
std::shared_ptr<spdlog::sinks::sink> QueuedSink(std::shared_ptr<spdlog::sinks::sink> sink,
                                                std::size_t max_line_count);

}  // namespace dcloc::server
