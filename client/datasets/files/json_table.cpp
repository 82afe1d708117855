#include "client/datasets/files/json_table.h"

#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "client/datasets/files/file_error.h"

namespace dcloc {

using nlohmann::json;

const TableRecord::Field* TableRecord::Find(absl::string_view key, Kind kind,
                                            const char* kind_name) {
  for (std::size_t i = 0; i < field_count_; ++i) {
    if (fields_[i].key != key) continue;
    if (fields_[i].kind == kind) return &fields_[i];
    Fail(key, absl::StrCat("must be ", kind_name));
    return nullptr;
  }
  Fail(key, "is missing");
  return nullptr;
}

void TableRecord::Fail(absl::string_view key, absl::string_view what) {
  status_.Update(absl::DataLossError(absl::StrCat("\"", key, "\" ", what)));
}

absl::string_view TableRecord::Text(absl::string_view key) {
  const Field* field = Find(key, Kind::kText, "a string");
  return field == nullptr ? absl::string_view{} : absl::string_view(field->text);
}

std::int64_t TableRecord::Integer(absl::string_view key) {
  const Field* field = Find(key, Kind::kInteger, "an integer");
  return field == nullptr ? 0 : field->integer;
}

std::chrono::microseconds TableRecord::Time(absl::string_view key) {
  const std::int64_t time_us = Integer(key);
  if (time_us >= -kMaxTime_us && time_us <= kMaxTime_us) return std::chrono::microseconds(time_us);
  Fail(key, absl::StrCat("is ", time_us, "; it must be a time within ", kMaxTime_us,
                         " microseconds of 1970"));
  return {};
}

/// Builds one record at a time from the parser's events (nlohmann's SAX interface).
class TableHandler {
 public:
  TableHandler(const std::filesystem::path& path,
               const std::function<absl::Status(TableRecord&)>& visit)
      : path_(path), visit_(visit) {}

  const absl::Status& status() const { return status_; }

  // The names of the events are the library's.
  // NOLINTBEGIN(readability-identifier-naming)
  bool null() { return Other(); }
  bool boolean(bool /*value*/) { return Other(); }
  bool binary(json::binary_t& /*value*/) { return Other(); }

  bool number_integer(std::int64_t value) {
    if (depth_ == kFieldDepth) Field().integer = value;
    return Number(static_cast<double>(value), TableRecord::Kind::kInteger);
  }
  bool number_unsigned(std::uint64_t value) {
    if (value <= static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())) {
      return number_integer(static_cast<std::int64_t>(value));
    }
    return Number(static_cast<double>(value), TableRecord::Kind::kOther);
  }
  bool number_float(double value, const std::string& /*text*/) {
    return Number(value, TableRecord::Kind::kOther);
  }

  bool string(std::string& value) {
    if (depth_ != kFieldDepth) return Other();
    Field().kind = TableRecord::Kind::kText;
    Field().text.swap(value);
    return true;
  }

  bool key(std::string& value) {
    if (depth_ != kFieldDepth) return true;
    if (record_.field_count_ == record_.fields_.size()) record_.fields_.emplace_back();
    ++record_.field_count_;
    Field().key.swap(value);
    Field().kind = TableRecord::Kind::kOther;
    Field().numbers.clear();
    return true;
  }

  bool start_array(std::size_t /*size*/) {
    if (depth_ == kRecordDepth) return Fail("is not an array of objects");
    if (depth_ == kFieldDepth) Field().kind = TableRecord::Kind::kNumbers;
    if (depth_ > kFieldDepth) Field().kind = TableRecord::Kind::kOther;
    ++depth_;
    return true;
  }
  bool end_array() {
    --depth_;
    return true;
  }

  bool start_object(std::size_t /*size*/) {
    if (depth_ == 0) return Fail("is not an array of objects");
    if (depth_ == kRecordDepth) {
      record_.field_count_ = 0;
      record_.status_ = absl::OkStatus();
    } else {
      Field().kind = TableRecord::Kind::kOther;
    }
    ++depth_;
    return true;
  }
  bool end_object() {
    --depth_;
    return depth_ != kRecordDepth || Visit();
  }

  bool parse_error(std::size_t position, const std::string& /*token*/,
                   const json::exception& error) {
    return Fail(absl::StrCat("is not valid JSON near byte ", position, ": ", error.what()));
  }
  // NOLINTEND(readability-identifier-naming)

 private:
  static constexpr int kRecordDepth = 1;  // inside the table's array
  static constexpr int kFieldDepth = 2;   // inside a record's object

  TableRecord::Field& Field() { return record_.fields_[record_.field_count_ - 1]; }

  bool Number(double value, TableRecord::Kind scalar_kind) {
    if (depth_ < kFieldDepth) return Fail("is not an array of objects");
    if (depth_ == kFieldDepth) Field().kind = scalar_kind;
    if (depth_ == kFieldDepth + 1) Field().numbers.push_back(value);
    return true;
  }

  bool Other() {
    if (depth_ < kFieldDepth) return Fail("is not an array of objects");
    Field().kind = TableRecord::Kind::kOther;
    return true;
  }

  bool Visit() {
    absl::Status status = visit_(record_);
    if (!record_.status().ok()) {
      return Fail(absl::StrCat("record ", record_index_, ": ", record_.status().message()));
    }
    if (!status.ok()) {
      return Fail(absl::StrCat("record ", record_index_, ": ", status.message()));
    }
    ++record_index_;
    return true;
  }

  bool Fail(absl::string_view what) {
    status_.Update(FileError(path_, what));
    return false;
  }

  const std::filesystem::path& path_;
  const std::function<absl::Status(TableRecord&)>& visit_;
  TableRecord record_;
  std::size_t record_index_ = 0;
  int depth_ = 0;
  absl::Status status_;
};

absl::Status ReadTable(const std::filesystem::path& path,
                       const std::function<absl::Status(TableRecord&)>& visit) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return CannotOpen(path);
  TableHandler handler(path, visit);
  const bool parsed = json::sax_parse(file, &handler);
  if (!handler.status().ok()) return handler.status();
  if (!parsed) return FileError(path, "is not valid JSON");
  return absl::OkStatus();
}

}  // namespace dcloc
