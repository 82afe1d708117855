#include "client/datasets/files/stamped_rows.h"

#include <array>
#include <cmath>

#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/memory_file.h"

namespace dcloc {

namespace {

constexpr std::array<const char*, 3> kColumns = {"wx", "wy", "wz"};
constexpr std::array kUnits = {StampUnit::kSeconds, StampUnit::kNanoseconds};

}  // namespace

std::vector<FuzzInput> FuzzSeeds() {
  std::vector<FuzzInput> seeds = {
      InputOf("# stamp x y z qx qy qz qw\n"
              "1700000000.125 1 2 3 0 0 0 1\n1700000000.225 1.5 2 3 0 0 0.6 0.8\n"),
      InputOf("1700000000125000000,1,2,3,0,0,0,1\r\n1700000000225000000,-1e-3,2,3,1,0,0,0\r\n"),
      InputOf("stamp,wx,wy,wz\n1700000000125000000,0.1,0.2,-0.3\n")};
  MemoryFile file;
  for (std::size_t i = 0; i < kUnits.size(); ++i) {
    const auto poses = ReadStampedPoses(file.Write(seeds[i].data(), seeds[i].size()), kUnits[i]);
    Require(poses.ok() && poses->size() == 2, "the seeds are valid");
  }
  const auto rows = ReadStampedRows(file.Write(seeds[2].data(), seeds[2].size()),
                                    StampUnit::kNanoseconds, kColumns);
  Require(rows.ok() && rows->size() == 1, "the seeds are valid");
  return seeds;
}

}  // namespace dcloc

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  dcloc::MemoryFile file;
  const auto& path = file.Write(data, size);
  for (const dcloc::StampUnit unit : dcloc::kUnits) {
    const auto rows = dcloc::ReadStampedRows(path, unit, dcloc::kColumns);
    if (rows.ok()) {
      for (std::size_t i = 0; i < rows->size(); ++i) {
        dcloc::Require((*rows)[i].values.size() >= dcloc::kColumns.size(), "no row is too short");
        dcloc::Require(i == 0 || (*rows)[i - 1].stamp < (*rows)[i].stamp, "stamps ascend");
      }
    }
    const auto poses = dcloc::ReadStampedPoses(path, unit);
    if (!poses.ok()) continue;
    for (const dcloc::StampedPose& entry : *poses) {
      const double norm = entry.pose.rotation.norm();
      dcloc::Require(std::abs(norm - 1.0) < 1e-6, "rotations are rotations");
    }
  }
  return 0;
}
