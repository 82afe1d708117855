#pragma once

namespace dcloc::server {

/// Whether the command line is one of `dcloc-server token ...`.
bool IsTokenCommand(int argc, const char* const* argv);

/// Runs `dcloc-server token create|list|revoke` on a store's identities, beside a running server or
/// without one. Returns the exit code: 0, 1 for a failure, 2 for wrong usage.
int RunTokenCommand(int argc, const char* const* argv);

}  // namespace dcloc::server
