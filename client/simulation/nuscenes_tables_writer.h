#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "client/simulation/simulation.h"

namespace dcloc {

/// Where a scan of a pass is stored.
struct StoredSweep {
  std::string filename;  ///< below the root
  bool is_key_frame = false;
  std::size_t sample = 0;  ///< the key frame's sample, or the next one after a sweep between
};

/// How a pass lies on disk: one log, one scene, samples every half second.
struct StoredPass {
  std::string logfile;
  std::string date;                        ///< YYYY-MM-DD
  std::vector<std::int64_t> sample_times;  ///< [us]
  std::vector<StoredSweep> sweeps;         ///< one for each scan of the drive
};

/// Names the files of `pass` and picks its key frames: of each radar the sweep nearest to each
/// sample. `pass` has at least one scan.
StoredPass PlanStorage(const SimulatedPass& pass);

/// The tables of a nuScenes version folder, growing by whole passes. Tokens are hashes of what they
/// stand for: the same simulation has the same tokens.
class NuScenesTables {
 public:
  void AddPass(const SimulatedPass& pass, const StoredPass& stored);

  /// Every table by its file's name without `.json`.
  std::vector<std::pair<std::string, nlohmann::ordered_json>> All() const;

  /// File of the blank map raster, below the root.
  std::string map_filename() const;

 private:
  void AddLogAndScene(const SimulatedPass& pass, const StoredPass& stored);
  void AddSensors(const SimulatedPass& pass);
  void AddSweeps(const SimulatedPass& pass, const StoredPass& stored);

  using Table = nlohmann::ordered_json;
  Table scene_ = Table::array();
  Table sample_ = Table::array();
  Table sample_data_ = Table::array();
  Table ego_pose_ = Table::array();
  Table sensor_ = Table::array();
  Table calibrated_sensor_ = Table::array();
  Table log_ = Table::array();
  Table log_tokens_ = Table::array();
};

/// `can_bus/<pass>_pose.json`.
nlohmann::ordered_json CanBusPose(const SimulatedPass& pass);

/// `dcloc_rig.json`.
nlohmann::ordered_json RigDescription(const Rig& rig, const SimulationOptions& options);

}  // namespace dcloc
