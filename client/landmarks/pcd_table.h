#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace dcloc {

/// A point cloud as rows of numbers.
struct PcdTable {
  std::vector<std::string> fields;
  std::vector<std::vector<double>> rows;

  /// The column of a field; `fields.size()` where there is none.
  std::size_t ColumnOf(absl::string_view field) const;
};

/// Reads a PCD file, ascii or binary, fields of any type with one value each. DataLoss says what is
/// wrong; Unimplemented for compressed data.
absl::StatusOr<PcdTable> ParsePcd(absl::string_view bytes);

}  // namespace dcloc
