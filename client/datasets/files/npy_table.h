#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace dcloc {

/// NumPy's name of a type of numbers, little-endian.
template <typename Number>
constexpr const char* NpyTypeName();
template <>
constexpr const char* NpyTypeName<float>() {
  return "<f4";
}
template <>
constexpr const char* NpyTypeName<double>() {
  return "<f8";
}
template <>
constexpr const char* NpyTypeName<std::int8_t>() {
  return "|i1";
}
template <>
constexpr const char* NpyTypeName<std::uint8_t>() {
  return "|u1";
}
template <>
constexpr const char* NpyTypeName<std::uint32_t>() {
  return "<u4";
}
template <>
constexpr const char* NpyTypeName<std::int64_t>() {
  return "<i8";
}

/// A NumPy file of one dimension whose rows have named fields, as it lies on disk.
class NpyTable {
 public:
  /// Reads the file (format 1 to 3). NotFound, or DataLoss that names the path and what is wrong:
  /// not a NumPy file, without named fields, in Fortran order, of another dimension, or with more
  /// or fewer bytes than its rows need.
  static absl::StatusOr<NpyTable> Read(const std::filesystem::path& path);

  std::size_t row_count() const { return row_count_; }

  /// The field's values, row by row. DataLoss, naming path and field, where it is not there or of
  /// another type than `Number`.
  template <typename Number>
  absl::StatusOr<std::vector<Number>> Column(absl::string_view name) const {
    const absl::StatusOr<std::size_t> offset = OffsetOf(name, NpyTypeName<Number>());
    if (!offset.ok()) return offset.status();
    std::vector<Number> values(row_count_);
    for (std::size_t i = 0; i < row_count_; ++i) {
      std::memcpy(&values[i], rows_.data() + i * row_bytes_ + *offset, sizeof(Number));
    }
    return values;
  }

 private:
  struct Field {
    std::string type;
    std::size_t offset = 0;
  };

  absl::Status TakeHeader(absl::string_view header);
  absl::Status TakeFields(absl::string_view description);
  absl::StatusOr<std::size_t> OffsetOf(absl::string_view name, absl::string_view type) const;

  std::filesystem::path path_;
  std::map<std::string, Field, std::less<>> fields_;
  std::size_t row_count_ = 0;
  std::size_t row_bytes_ = 0;
  std::string rows_;
};

}  // namespace dcloc
