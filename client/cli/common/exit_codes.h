#pragma once

namespace dcloc::cli {

/// What `dcloc` returns to the shell.
inline constexpr int kSuccess = 0;
inline constexpr int kFailure = 1;  ///< the command was understood and failed
inline constexpr int kUsage = 2;    ///< wrong usage

}  // namespace dcloc::cli
