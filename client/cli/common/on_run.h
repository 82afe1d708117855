#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <utility>

#include "absl/status/status.h"
#include "client/cli/common/exit_codes.h"
#include "client/cli/common/terminal.h"

namespace dcloc::cli {

/// Where `app` is chosen, calls `run`, which takes the arguments and returns an absl::Status, and
/// sets the exit code by it. An error is printed.
template <typename Arguments, typename Run>
void OnRun(CLI::App& app, std::shared_ptr<Arguments> arguments, int& exit_code, Run run) {
  app.callback([arguments = std::move(arguments), &exit_code, run = std::move(run)] {
    const absl::Status status = run(*arguments);
    exit_code = status.ok() ? kSuccess : Fail(status);
  });
}

}  // namespace dcloc::cli
