#include "client/datasets/files/json_table.h"

#include "client/datasets/can_bus.h"
#include "client/datasets/radarscenes_tables.h"
#include "tests/client/datasets/tiny_nuscenes.h"
#include "tests/client/datasets/tiny_radarscenes.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/memory_file.h"

namespace dcloc {

std::vector<FuzzInput> FuzzSeeds() {
  const TinyNuScenes scenes;
  const TinyRadarScenes sequence;
  return {InputOf(scenes.tables.at("ego_pose").dump()),
          InputOf(scenes.tables.at("calibrated_sensor").dump()),
          InputOf(scenes.files.at("can_bus/scene-0001_pose.json")),
          InputOf(sequence.sensors.dump()), InputOf(sequence.scenes.dump())};
}

}  // namespace dcloc

// The same bytes as each of the files in JSON: a reader must cope with another one's too.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  dcloc::MemoryFile file;
  const auto& path = file.Write(data, size);
  static_cast<void>(dcloc::ReadTable(path, [](dcloc::TableRecord& record) {
    static_cast<void>(record.Text("token"));
    static_cast<void>(record.Integer("timestamp"));
    static_cast<void>(record.Numbers<3>("translation"));
    static_cast<void>(record.Numbers<4>("rotation"));
    return record.status();
  }));
  static_cast<void>(dcloc::ReadCanBusPose(path));
  static_cast<void>(dcloc::ReadRadarScenesMounts(path));
  const auto scenes = dcloc::ReadRadarScenesScenes(path);
  if (!scenes.ok()) return 0;
  for (const dcloc::RadarScenesScene& scene : *scenes) {
    dcloc::Require(scene.begin <= scene.end, "rows of a scene are in order");
  }
  return 0;
}
