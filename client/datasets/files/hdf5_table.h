#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace dcloc {

/// Where a column of a compound HDF5 data set goes within a row of ours.
struct Hdf5Column {
  enum class Type { kInt64, kFloat };
  const char* name;
  Type type;  ///< std::int64_t or float; narrower and wider numbers on disk are converted
  std::size_t offset_bytes;
};

/// Sizes `rows` of the caller's when the number of rows is known, and says where they begin.
class Hdf5Rows {
 public:
  virtual ~Hdf5Rows() = default;
  virtual void* Resize(std::size_t row_count) = 0;
};

/// Reads the named columns of the compound data set `dataset`, and only those, into rows of
/// `row_bytes`. DataLoss names the file and what is wrong: no HDF5, truncated, no such data set or
/// column, or a column of another kind. Not to be called from two threads at once (HDF5 is not).
absl::Status ReadHdf5Columns(const std::filesystem::path& path, const std::string& dataset,
                             std::span<const Hdf5Column> columns, std::size_t row_bytes,
                             Hdf5Rows& rows);

/// The same for a plain struct `Row`.
template <typename Row>
absl::StatusOr<std::vector<Row>> ReadHdf5Table(const std::filesystem::path& path,
                                               const std::string& dataset,
                                               std::span<const Hdf5Column> columns) {
  struct VectorRows : Hdf5Rows {
    std::vector<Row> values;
    void* Resize(std::size_t row_count) override {
      values.resize(row_count);
      return values.data();
    }
  } rows;
  const absl::Status status = ReadHdf5Columns(path, dataset, columns, sizeof(Row), rows);
  if (!status.ok()) return status;
  return std::move(rows.values);
}

}  // namespace dcloc
