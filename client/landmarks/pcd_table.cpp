#include "client/landmarks/pcd_table.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "absl/strings/numbers.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"

namespace dcloc {
namespace {

using Words = std::vector<absl::string_view>;

struct Header {
  Words fields, sizes, types, counts;
  std::uint64_t point_count = 0;
  bool has_points = false;
  std::string data;
};

Words WordsOf(absl::string_view line) {
  return absl::StrSplit(line, absl::ByAnyChar(" \t\r"), absl::SkipEmpty());
}

// Takes the next line off `rest`.
absl::string_view TakeLine(absl::string_view& rest) {
  const std::size_t end = std::min(rest.find('\n'), rest.size());
  const absl::string_view line = rest.substr(0, end);
  rest.remove_prefix(std::min(end + 1, rest.size()));
  return line;
}

absl::StatusOr<Header> TakeHeader(absl::string_view& rest) {
  Header header;
  while (!rest.empty() && header.data.empty()) {
    Words words = WordsOf(TakeLine(rest));
    if (words.empty() || words[0][0] == '#') continue;
    const absl::string_view key = words[0];
    words.erase(words.begin());
    if (key == "FIELDS") header.fields = words;
    if (key == "SIZE") header.sizes = words;
    if (key == "TYPE") header.types = words;
    if (key == "COUNT") header.counts = words;
    if (key == "POINTS" && words.size() == 1) {
      header.has_points = absl::SimpleAtoi(words[0], &header.point_count);
    }
    if (key == "DATA" && words.size() == 1) header.data = std::string(words[0]);
  }
  const std::size_t count = header.fields.size();
  if (count == 0 || !header.has_points || header.data.empty()) {
    return absl::DataLossError("is no PCD file: FIELDS, POINTS or DATA are missing");
  }
  if (header.sizes.size() != count || header.types.size() != count) {
    return absl::DataLossError(absl::StrFormat("SIZE and TYPE have %d and %d words; FIELDS has %d",
                                               header.sizes.size(), header.types.size(), count));
  }
  if (std::ranges::any_of(header.counts, [](absl::string_view word) { return word != "1"; })) {
    return absl::DataLossError("COUNT must be 1 for every field");
  }
  return header;
}

template <typename T>
double ValueAt(const char* bytes) {
  T value{};
  std::memcpy(&value, bytes, sizeof(T));
  return static_cast<double>(value);
}

struct Column {
  std::size_t size_bytes;
  double (*read)(const char*);
};

absl::StatusOr<Column> ColumnFor(absl::string_view type, absl::string_view size) {
  const std::string kind = absl::StrFormat("%s%s", type, size);
  if (kind == "F4") return Column{4, ValueAt<float>};
  if (kind == "F8") return Column{8, ValueAt<double>};
  if (kind == "U1") return Column{1, ValueAt<std::uint8_t>};
  if (kind == "U2") return Column{2, ValueAt<std::uint16_t>};
  if (kind == "U4") return Column{4, ValueAt<std::uint32_t>};
  if (kind == "U8") return Column{8, ValueAt<std::uint64_t>};
  if (kind == "I1") return Column{1, ValueAt<std::int8_t>};
  if (kind == "I2") return Column{2, ValueAt<std::int16_t>};
  if (kind == "I4") return Column{4, ValueAt<std::int32_t>};
  if (kind == "I8") return Column{8, ValueAt<std::int64_t>};
  return absl::DataLossError(
      absl::StrFormat("TYPE %s with SIZE %s is none of F 4 8, U and I 1 2 4 8", type, size));
}

absl::Status ReadBinary(const Header& header, absl::string_view bytes, PcdTable& table) {
  std::vector<Column> columns;
  std::size_t row_bytes = 0;
  for (std::size_t i = 0; i < header.fields.size(); ++i) {
    const absl::StatusOr<Column> column = ColumnFor(header.types[i], header.sizes[i]);
    if (!column.ok()) return column.status();
    columns.push_back(*column);
    row_bytes += column->size_bytes;
  }
  if (bytes.size() / row_bytes < header.point_count) {
    return absl::DataLossError(absl::StrFormat("POINTS is %d; the data hold %d", header.point_count,
                                               bytes.size() / row_bytes));
  }
  const char* next = bytes.data();
  for (std::uint64_t i = 0; i < header.point_count; ++i) {
    std::vector<double>& row = table.rows.emplace_back();
    for (const Column& column : columns) {
      row.push_back(column.read(next));
      next += column.size_bytes;
    }
  }
  return absl::OkStatus();
}

absl::Status ReadAscii(const Header& header, absl::string_view text, PcdTable& table) {
  while (!text.empty()) {
    const Words words = WordsOf(TakeLine(text));
    if (words.empty()) continue;
    std::vector<double> row;
    for (const absl::string_view word : words) {
      double value = 0.0;
      if (!absl::SimpleAtod(word, &value)) {
        return absl::DataLossError(
            absl::StrFormat("point %d: '%s' is no number", table.rows.size(), word.substr(0, 40)));
      }
      row.push_back(value);
    }
    if (row.size() != header.fields.size()) {
      return absl::DataLossError(absl::StrFormat("point %d has %d values; FIELDS has %d",
                                                 table.rows.size(), row.size(),
                                                 header.fields.size()));
    }
    table.rows.push_back(std::move(row));
  }
  if (table.rows.size() == header.point_count) return absl::OkStatus();
  return absl::DataLossError(
      absl::StrFormat("POINTS is %d; the data hold %d", header.point_count, table.rows.size()));
}

}  // namespace

std::size_t PcdTable::ColumnOf(absl::string_view field) const {
  return static_cast<std::size_t>(std::ranges::find(fields, field) - fields.begin());
}

absl::StatusOr<PcdTable> ParsePcd(absl::string_view bytes) {
  const absl::StatusOr<Header> header = TakeHeader(bytes);
  if (!header.ok()) return header.status();
  PcdTable table{.fields = {header->fields.begin(), header->fields.end()}, .rows = {}};
  absl::Status status;
  if (header->data == "binary") {
    status = ReadBinary(*header, bytes, table);
  } else if (header->data == "ascii") {
    status = ReadAscii(*header, bytes, table);
  } else {
    status = absl::UnimplementedError(
        absl::StrFormat("DATA is '%s'; only ascii and binary are read", header->data));
  }
  if (!status.ok()) return status;
  return table;
}

}  // namespace dcloc
