#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <vector>

/// One input, of any bytes. Must neither crash nor keep state. Defined by each fuzz target.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace dcloc {

using FuzzInput = std::vector<std::uint8_t>;

/// Inputs worth mutating: valid ones. Defined by each fuzz target.
std::vector<FuzzInput> FuzzSeeds();

inline FuzzInput InputOf(std::string_view bytes) { return {bytes.begin(), bytes.end()}; }

/// Ends the process when what a target promises does not hold: that counts as a crash.
inline void Require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n", what);
  std::abort();
}

}  // namespace dcloc
