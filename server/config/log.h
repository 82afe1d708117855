#pragma once

#include <memory>
#include <string>

#include "absl/strings/string_view.h"
#include "server/config/config.h"
#include "spdlog/sinks/sink.h"

namespace dcloc::server {

/// The program's log: standard error, one line each, as text or as JSON, written by a thread of
/// its own. Block signals before.
void SetUpLog(const ServerConfig& config);

/// Waits until all logged lines are written, at most a second.
void FlushLog();

/// A line "session opened session=ab12 vehicle=\"car 1\"" as JSON members: what stands before the
/// first key is the event, the keys and their values follow, all of them strings. Gives
/// `"event":"session opened","session":"ab12","vehicle":"car 1"`.
std::string JsonMembers(absl::string_view line);

/// Passes on at most `lines_per_s`, with bursts of one second. A later line says how many were left
/// out. Errors always pass. A client's faults are logged, and a client must not be able to fill the
/// disk with them.
std::shared_ptr<spdlog::sinks::sink> LimitedSink(std::shared_ptr<spdlog::sinks::sink> sink,
                                                 int lines_per_s);

}  // namespace dcloc::server
