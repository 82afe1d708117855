#include "client/datasets/files/npy_table.h"

#include <string>

#include "client/rosbag/bag_bytes.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/memory_file.h"

namespace dcloc {
namespace {

/// A NumPy file of format 1 with two rows of three fields.
FuzzInput Table(const std::string& rows, const char* fortran = "False",
                const char* shape = "(2,)") {
  std::string header = std::string(
                           "{'descr': [('scan_index', '<u4'), ('timestamp', '<i8'), "
                           "('radar_range', '<f4')], 'fortran_order': ") +
                       fortran + ", 'shape': " + shape + ", }";
  header.append(63 - (10 + header.size()) % 64, ' ').push_back('\n');
  std::string bytes("\x93NUMPY\x01\x00", 8);
  rosbag::AppendNumber(bytes, static_cast<std::uint16_t>(header.size()));
  return InputOf(bytes + header + rows);
}

}  // namespace

std::vector<FuzzInput> FuzzSeeds() {
  std::string rows;
  for (std::uint32_t i = 0; i < 2; ++i) {
    rosbag::AppendNumber(rows, i);
    rosbag::AppendNumber(rows, std::int64_t{1'700'000'000'000'000'000} + i);
    rosbag::AppendNumber(rows, 12.5F);
  }
  const FuzzInput valid = Table(rows);
  MemoryFile file;
  const auto table = NpyTable::Read(file.Write(valid.data(), valid.size()));
  Require(table.ok() && table->row_count() == 2, "the seed is valid");
  return {valid, Table(rows, "True"), Table("", "False", "(0,)")};
}

}  // namespace dcloc

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  dcloc::MemoryFile file;
  const auto table = dcloc::NpyTable::Read(file.Write(data, size));
  if (!table.ok()) return 0;
  dcloc::Require(table->row_count() <= size, "each row has bytes of the file");
  static_cast<void>(table->Column<std::uint32_t>("scan_index"));
  static_cast<void>(table->Column<std::int64_t>("timestamp"));
  static_cast<void>(table->Column<float>("radar_range"));
  static_cast<void>(table->Column<double>("radar_range"));
  return 0;
}
