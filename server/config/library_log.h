#pragma once

#include <memory>

#include "spdlog/logger.h"

namespace dcloc::server {

/// Has what gRPC and protobuf say of their own accord logged by `log`, one line each, instead of
/// written to standard error. Outsiders can make them say much, so nothing of it is more than a
/// warning, which `LimitedSink` limits. `log` is found by its name from then on.
void TakeLibraryMessages(const std::shared_ptr<spdlog::logger>& log);

}  // namespace dcloc::server
