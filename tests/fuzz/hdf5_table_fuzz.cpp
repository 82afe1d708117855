#include "client/datasets/files/hdf5_table.h"

#include <fstream>
#include <iterator>

#include "client/datasets/radarscenes_tables.h"
#include "tests/client/datasets/tiny_radarscenes.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/memory_file.h"

namespace dcloc {

std::vector<FuzzInput> FuzzSeeds() {
  const TempFolder folder;
  TinyRadarScenes().WriteTo(folder);
  std::ifstream file(folder.path() / "data/sequence_7/radar_data.h5", std::ios::binary);
  return {FuzzInput{std::istreambuf_iterator<char>(file), {}}};
}

}  // namespace dcloc

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  dcloc::MemoryFile file;
  const auto& path = file.Write(data, size);
  static_cast<void>(dcloc::ReadRadarScenesTargets(path));
  static_cast<void>(dcloc::ReadRadarScenesOdometry(path));
  return 0;
}
