#pragma once

namespace dcloc::server {

/// Whether the command line is one of `dcloc-server store ...`.
bool IsStoreCommand(int argc, const char* const* argv);

/// Runs `dcloc-server store check|repair|backup|restore`. SIGINT and SIGTERM stop it and leave
/// nothing half done. Returns the exit code: 0, 1 for a failure or a store that is not whole, 2 for
/// wrong usage.
int RunStoreCommand(int argc, const char* const* argv);

}  // namespace dcloc::server
