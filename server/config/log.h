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

/// Waits until what was logged is written, or a second if nobody takes it.
void FlushLog();

/// A line "session opened session=ab12 vehicle=\"car 1\"" as JSON members: what stands before the
/// first key is the event, the keys and their values follow, all of them strings. Gives
/// `"event":"session opened","session":"ab12","vehicle":"car 1"`.
std::string JsonMembers(absl::string_view line);

/// Hands on at most `lines_per_s`, with a second's worth at once; says how many lines were left out
/// when there is room again. Errors always pass. What a client does wrong makes lines: nobody may
/// fill a disk with them.
std::shared_ptr<spdlog::sinks::sink> LimitedSink(std::shared_ptr<spdlog::sinks::sink> sink,
                                                 int lines_per_s);

}  // namespace dcloc::server
