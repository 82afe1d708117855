#pragma once

#include <optional>
#include <string>
#include <vector>

namespace dcloc {

/// Which drive of a dataset is read, and with which radars.
struct DriveRequest {
  std::string name;                 ///< "scene-0061", "sequence_108"
  std::vector<std::string> radars;  ///< ids; all radars of the drive when empty
  std::optional<double> beta_s;     ///< in place of every radar's own
};

}  // namespace dcloc
