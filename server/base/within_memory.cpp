#include "server/base/within_memory.h"

namespace dcloc::server {
namespace {

// Shorter than what a std::string keeps in itself.
const absl::Status out_of_memory = absl::ResourceExhaustedError("out of memory");

}  // namespace

const absl::Status& OutOfMemory() { return out_of_memory; }

}  // namespace dcloc::server
