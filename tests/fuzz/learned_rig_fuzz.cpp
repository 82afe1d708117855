#include "client/cli/remote/learned_rig.h"

#include <string>

#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/memory_file.h"

namespace dcloc {

std::vector<FuzzInput> FuzzSeeds() {
  return {InputOf(R"({"radars": [{"radar_id": "front", "mount_yaw_error_rad":)"
                  R"( {"value": 0.02, "sigma": 0.003}, "stamp_delay_s": {"value": 0.11},)"
                  R"( "range_bias_error_m": {"value": -0.4, "sigma": 0.05}}],)"
                  R"( "odometry_delay_s": {"value": 0.15, "sigma": 0.01},)"
                  R"( "wheel_scale": {"value": 1.02}, "of_a_newer_client": [{"a": [1, {}]}]})"),
          InputOf(R"({"radars": [{"radarId": "front", "clockAheadS": {"value": -1e-3}}]})"),
          InputOf("{}")};
}

}  // namespace dcloc

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  dcloc::MemoryFile file;
  const auto read = dcloc::cli::ReadLearnedRig(file.Write(data, size));
  if (!read.ok()) return 0;
  dcloc::Require(read->has_value(), "the file is there");
  dcloc::Require(!dcloc::cli::LearnedRigText(**read).empty(), "people are told what it holds");
  const dcloc::RigKnowledge known = dcloc::cli::FromProto(**read);
  if (!dcloc::Validate(known).ok()) return 0;
  const dcloc::RigKnowledge again = dcloc::cli::FromProto(dcloc::cli::ToProto(known));
  dcloc::Require(!dcloc::HasChanged(known, again), "what is valid is kept");
  return 0;
}
