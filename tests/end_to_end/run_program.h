#pragma once

#include <cstdio>
#include <cstdlib>
#include <exception>

namespace dcloc {

/// What a program's main returns: `run`'s exit status, or failure with the message of what the
/// standard library throws.
inline int RunProgram(int (*run)(int, char**), int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fputs(error.what(), stderr);
    return EXIT_FAILURE;
  }
}

}  // namespace dcloc
