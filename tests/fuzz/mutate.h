#pragma once

#include <random>
#include <vector>

#include "tests/fuzz/fuzz_target.h"

namespace dcloc {

/// Changes `input` in one to four places at random, as a careless or hostile writer would: bits,
/// bytes, extreme numbers in binary and as text, cuts, repeats, and pieces of the `others`.
void Mutate(FuzzInput& input, const std::vector<FuzzInput>& others, std::mt19937& random);

}  // namespace dcloc
