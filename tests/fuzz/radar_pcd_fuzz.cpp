#include "client/datasets/files/radar_pcd.h"

#include <cmath>

#include "tests/client/datasets/tiny_nuscenes.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/memory_file.h"

namespace dcloc {

std::vector<FuzzInput> FuzzSeeds() {
  return {InputOf(PcdBytes({{20.0F, 1.0F}, {30.0F, -4.0F}, {5.0F, 0.5F}})), InputOf(PcdBytes({})),
          InputOf("VERSION 0.7\nFIELDS vy vx rcs z y x invalid_state ambig_state dyn_prop\n"
                  "SIZE 4 4 4 4 4 4 2 4 1\nTYPE F F F F F F U U I\nCOUNT 1 1 1 1 1 1 1 1 1\n"
                  "WIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA binary\n0123456789012345678901234567890")};
}

}  // namespace dcloc

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  dcloc::MemoryFile file;
  const auto targets = dcloc::ReadRadarPcd(file.Write(data, size));
  if (!targets.ok()) return 0;
  dcloc::Require(targets->size() <= size, "each target has bytes of the file");
  for (const dcloc::RadarPcdTarget& target : *targets) {
    dcloc::Require(!std::isnan(target.x_m) && !std::isnan(target.vx_mps), "NaN rows are left out");
  }
  return 0;
}
