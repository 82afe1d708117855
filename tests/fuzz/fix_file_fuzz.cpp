#include "client/datasets/fix_file.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/memory_file.h"

namespace dcloc {

std::vector<FuzzInput> FuzzSeeds() {
  return {InputOf("stamp_ns,latitude_deg,longitude_deg,height_m,horizontal_sigma_m,"
                  "vertical_sigma_m,heading_deg,heading_sigma_deg\n"
                  "1700000000000000000,52.1,8.2,100,2.5,4,90,1\n"
                  "1700000000200000000,52.1001,8.2,100,2.5,4,,\n"),
          InputOf("stamp_ns,x_m,y_m,z_m,horizontal_sigma_m,vertical_sigma_m\r\n"
                  "1700000000000000000,12.5,-3,0.25,1,2\r\n"
                  "1700000000100000000,13.5,-3,0.25,1,2\r\n"),
          InputOf("yaw_sigma_deg,x_m,y_m,z_m,horizontal_sigma_m,vertical_sigma_m,yaw_deg,stamp_ns\n"
                  "0.5,12.5,-3,0.25,1,2,180,1700000000000000000\n")};
}

}  // namespace dcloc

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  dcloc::MemoryFile file;
  const auto fixes = dcloc::ReadFixes(file.Write(data, size));
  if (!fixes.ok()) return 0;
  // What was read can be written, and then read again.
  if (fixes->empty()) return 0;
  dcloc::MemoryFile again;
  if (!dcloc::WriteFixes(again.path(), *fixes).ok()) return 0;
  const auto twice = dcloc::ReadFixes(again.path());
  dcloc::Require(twice.ok() && twice->size() == fixes->size(), "fixes are read as written");
  return 0;
}
