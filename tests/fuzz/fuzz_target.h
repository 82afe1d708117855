#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

/// One input, of any bytes. Must neither crash nor keep state. Defined by each fuzz target.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace dcloc {

/// Inputs worth mutating: valid ones. Defined by each fuzz target.
std::vector<std::vector<std::uint8_t>> FuzzSeeds();

}  // namespace dcloc
