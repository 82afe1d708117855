#include "client/datasets/rig_file.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/memory_file.h"

namespace dcloc {

std::vector<FuzzInput> FuzzSeeds() {
  return {InputOf(R"({"radars": [{"id": "front", "beta_s": 0.04, "range_sigma_m": 0.1,)"
                  R"( "mount_yaw_correction_rad": 0.01, "has_elevation": false},)"
                  R"( {"id": "rear", "azimuth_sigma_rad": 0.02}]})"),
          InputOf(R"({"radars": [{"id": "front"}]})")};
}

}  // namespace dcloc

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  dcloc::Rig rig;
  rig.radars.emplace_back().id = "front";
  const dcloc::Rig before = rig;
  dcloc::MemoryFile file;
  if (dcloc::ApplyRigFile(file.Write(data, size), rig).ok()) {
    dcloc::Require(rig.radars.size() == before.radars.size(), "no radar comes or goes");
    dcloc::Require(dcloc::Validate(rig).ok(), "a rig that was taken is valid");
  }
  return 0;
}
