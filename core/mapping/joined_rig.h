#pragma once

#include <string>

#include "core/radar/radar_model.h"

namespace dcloc {

/// The radars of several drives in one rig. A radar that two drives describe alike is one; of one
/// id described differently, the later drive's is called "ID@DRIVE".
class JoinedRig {
 public:
  void Add(const std::string& drive, const Rig& rig);

  const Rig& rig() const { return rig_; }
  /// The id in the joined rig of a radar of a drive that was added.
  std::string IdOf(const std::string& drive, const RadarModel& radar) const;

 private:
  Rig rig_;
};

}  // namespace dcloc
