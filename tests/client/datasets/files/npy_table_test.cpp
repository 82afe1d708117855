// Tables of NumPy: what numpy.save writes of rows with named fields.
#include "client/datasets/files/npy_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/client/datasets/temp_folder.h"

namespace dcloc {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// The bytes of numpy.save for rows of one '<u4' and one '<f4'.
std::string Npy(const std::string& header, const std::string& rows, char version = 1) {
  std::string bytes = "\x93NUMPY";
  bytes += version;
  bytes += '\0';
  bytes += static_cast<char>(header.size() % 256);
  bytes += static_cast<char>(header.size() / 256);
  if (version > 1) bytes += std::string(2, '\0');
  return bytes + header + rows;
}

class NpyTableTest : public ::testing::Test {
 protected:
  std::string Error(const std::string& bytes) const {
    const absl::Status status = NpyTable::Read(folder_.Write("a.npy", bytes)).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
    return std::string(status.message());
  }
  const std::string header_ =
      "{'descr': [('index', '<u4'), ('', '|V2'), ('rate', '<f4')], 'fortran_order': False, "
      "'shape': (2,), }\n";
  const std::string rows_{"\1\0\0\0--\0\0\x80\x3f\2\0\0\0--\0\0\0\xc0", 20};
  const TempFolder folder_;
};

TEST_F(NpyTableTest, FieldsAreReadByTheirNames) {
  for (const char version : {'\1', '\2', '\3'}) {
    const auto table = NpyTable::Read(folder_.Write("a.npy", Npy(header_, rows_, version)));
    ASSERT_TRUE(table.ok()) << table.status();
    EXPECT_EQ(table->row_count(), 2U);
    EXPECT_THAT(*table->Column<std::uint32_t>("index"), ElementsAre(1, 2));
    EXPECT_THAT(*table->Column<float>("rate"), ElementsAre(1.0F, -2.0F));
    EXPECT_THAT(std::string(table->Column<double>("rate").status().message()),
                HasSubstr("a.npy: field \"rate\" is of type '<f4'; it must be '<f8'"));
    EXPECT_THAT(std::string(table->Column<float>("range").status().message()),
                HasSubstr("has no field \"range\"; its fields are , index, rate"));
  }
}

TEST_F(NpyTableTest, WhatIsNoSuchTableIsNamed) {
  EXPECT_THAT(Error("NUMPY"), HasSubstr("is no NumPy file"));
  EXPECT_THAT(Error(Npy("{'descr': '<f4', 'fortran_order': False, 'shape': (5,), }", rows_)),
              HasSubstr("descr is '<f4'; it must be a list of named fields"));
  EXPECT_THAT(
      Error(Npy("{'descr': [('a', '<f4')], 'fortran_order': True, 'shape': (5,), }", rows_)),
      HasSubstr("fortran_order is not False"));
  EXPECT_THAT(
      Error(Npy("{'descr': [('a', '<f4')], 'fortran_order': False, 'shape': (1, 5), }", rows_)),
      HasSubstr("shape is (1, 5); it must have one dimension"));
  EXPECT_THAT(
      Error(Npy("{'descr': [('a', 'object')], 'fortran_order': False, 'shape': (5,), }", rows_)),
      HasSubstr("descr has a field \"a\" of the type 'object'"));
  EXPECT_THAT(Error(Npy("{'shape': (5,), }", rows_)), HasSubstr("does not tell descr"));
  EXPECT_THAT(Error(Npy(header_, rows_ + "x")),
              HasSubstr("has 21 bytes of rows; 2 rows of 10 bytes are announced"));
}

TEST_F(NpyTableTest, NoCutMakesItFallOver) {
  const std::string whole = Npy(header_, rows_);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(NpyTable::Read(folder_.Write("a.npy", whole.substr(0, size))).ok()) << size;
  }
}

}  // namespace
}  // namespace dcloc
