#include "client/datasets/bag_mapping.h"

#include "nlohmann/json.hpp"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/memory_file.h"

namespace dcloc {

std::vector<FuzzInput> FuzzSeeds() {
  BagMapping polar;
  polar.radars = {{.id = "front",
                   .topic = "/front",
                   .range = "range",
                   .azimuth = "azimuth",
                   .range_rate = "doppler",
                   .T_vehicle_radar = Pose3()}};
  polar.motion_topic = "/odom";
  BagMapping flat;
  flat.radars = {{.id = "rear", .topic = "/rear", .x = "x", .y = "y", .range_rate = "v"}};
  flat.imu_topic = "/imu";
  flat.velocity_by_doppler = true;
  flat.reference_file = "poses.txt";
  Require(Validate(polar).ok() && Validate(flat).ok(), "the seeds are valid");
  return {InputOf(BagMappingJson(polar).dump(2)), InputOf(BagMappingJson(flat).dump()),
          InputOf("{}")};
}

}  // namespace dcloc

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  dcloc::MemoryFile file;
  const auto mapping = dcloc::ReadBagMapping(file.Write(data, size));
  if (!mapping.ok()) return 0;
  dcloc::Require(dcloc::Validate(*mapping).ok(), "what is read is valid");
  const std::string written = dcloc::BagMappingJson(*mapping).dump();
  dcloc::MemoryFile again;
  const auto twice = dcloc::ReadBagMapping(
      again.Write(reinterpret_cast<const std::uint8_t*>(written.data()), written.size()));
  dcloc::Require(twice.ok() && dcloc::BagMappingJson(*twice).dump() == written,
                 "a mapping is read as written");
  return 0;
}
