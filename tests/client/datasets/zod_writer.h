#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "client/datasets/drive.h"
#include "core/geometry/geodetic_anchor.h"

namespace dcloc {

/// A NumPy file of rows with named fields; `types` by name, in the order of the rows' bytes.
std::string NpyBytes(const std::vector<std::pair<std::string, std::string>>& types,
                     std::size_t row_count, const std::string& rows, bool fortran_order = false);

/// A drive of ZOD: its name, and where its poses are counted from, in the frame of the simulation.
struct ZodDrive {
  std::string id;
  const Drive* drive = nullptr;
  Eigen::Vector3d p_map_origin = Eigen::Vector3d::Zero();
};

/// Where the simulation's frame lies: a point that drives near it share.
GeodeticAnchor ZodAnchor();

/// Writes drives of one radar as the data set has them: trainval-drives-mini.json, and for each a
/// table of radar targets, a calibration, and its motion with turn rates counted clockwise.
void WriteZod(const std::vector<ZodDrive>& drives, const std::filesystem::path& root);

}  // namespace dcloc
