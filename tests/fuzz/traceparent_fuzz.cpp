#include "server/base/traceparent.h"

#include <algorithm>
#include <string>

#include "tests/fuzz/fuzz_target.h"

namespace dcloc {

std::vector<FuzzInput> FuzzSeeds() {
  return {InputOf("00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01"),
          InputOf("01-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-00-more")};
}

}  // namespace dcloc

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string id =
      dcloc::server::TraceIdOf(absl::string_view(reinterpret_cast<const char*>(data), size));
  const auto is_digit = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); };
  dcloc::Require(id.empty() || (id.size() == 32 && std::ranges::all_of(id, is_digit)),
                 "an id has 32 digits");
  return 0;
}
