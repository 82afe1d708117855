#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace dcloc::cli {

/// The manual page of `app` (section 1, troff), a program of that version.
std::string ManualPage(const CLI::App& app, const std::string& version);

}  // namespace dcloc::cli
