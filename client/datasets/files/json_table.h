#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace dcloc {

/// Times further from 1970 have no stamps in nanoseconds whose differences can be told.
inline constexpr std::int64_t kMaxTime_us = 4'000'000'000'000'000;

/// One record of a table: an object's fields. Its accessors answer a neutral value for a field that
/// is missing or of another type and remember the first such fault in `status`, so that a reader
/// can take all its fields and look at the status once.
class TableRecord {
 public:
  absl::string_view Text(absl::string_view key);
  std::int64_t Integer(absl::string_view key);
  /// An integer of at most `kMaxTime_us` to either side.
  std::chrono::microseconds Time(absl::string_view key);
  template <std::size_t N>
  std::array<double, N> Numbers(absl::string_view key);

  /// The first fault, without the file's name and the record's index, which `ReadTable` adds.
  const absl::Status& status() const { return status_; }

 private:
  friend class TableHandler;
  enum class Kind { kText, kInteger, kNumbers, kOther };
  struct Field {
    std::string key;
    Kind kind = Kind::kOther;
    std::string text;
    std::int64_t integer = 0;
    std::vector<double> numbers;
  };

  const Field* Find(absl::string_view key, Kind kind, const char* kind_name);
  void Fail(absl::string_view key, absl::string_view what);

  // Fields are reused from record to record, so that a long table allocates nothing per record.
  std::vector<Field> fields_;
  std::size_t field_count_ = 0;
  absl::Status status_;
};

/// Reads a nuScenes table, an array of flat objects, and calls `visit` for each in turn. One record
/// is in memory at a time, whatever the file's size. Stops at the first error: one of the file, of
/// the record's `status`, or that `visit` returns. All of them name the file.
absl::Status ReadTable(const std::filesystem::path& path,
                       const std::function<absl::Status(TableRecord&)>& visit);

template <std::size_t N>
std::array<double, N> TableRecord::Numbers(absl::string_view key) {
  std::array<double, N> values{};
  const Field* field = Find(key, Kind::kNumbers, "an array of numbers");
  if (field == nullptr) return values;
  if (field->numbers.size() != N) {
    Fail(key, absl::StrCat("has ", field->numbers.size(), " numbers; it must have ", N));
    return values;
  }
  for (std::size_t i = 0; i < N; ++i) values[i] = field->numbers[i];
  return values;
}

}  // namespace dcloc
