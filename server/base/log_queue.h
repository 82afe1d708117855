#pragma once

#include <cstddef>
#include <memory>

#include "spdlog/sinks/sink.h"

namespace dcloc::server {

/// Hands lines to `sink` on a thread of its own, so that nobody who logs waits for a disk or for
/// the reader of a pipe. Of more than `max_line_count` that wait the oldest go, and a line says how
/// many. `flush` and the end wait for what is there, but no longer than a second for a sink that is
/// stuck.
std::shared_ptr<spdlog::sinks::sink> QueuedSink(std::shared_ptr<spdlog::sinks::sink> sink,
                                                std::size_t max_line_count);

}  // namespace dcloc::server
