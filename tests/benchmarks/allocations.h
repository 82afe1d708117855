#pragma once

#include <cstdint>

namespace dcloc::benchmarks {

/// Calls of malloc and its kin by this thread since it began. Linking this in replaces the
/// program's allocation functions by ones that count.
std::int64_t AllocationCount();

}  // namespace dcloc::benchmarks
