#include "client/datasets/files/npy_table.h"

#include <fstream>
#include <iterator>
#include <optional>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/strip.h"
#include "client/datasets/files/file_error.h"

namespace dcloc {
namespace {

constexpr absl::string_view kMagic = "\x93NUMPY";

/// What follows `key` in the header, a Python dictionary that NumPy writes always alike.
std::optional<absl::string_view> After(absl::string_view header, absl::string_view key) {
  const std::size_t at = header.find(absl::StrCat("'", key, "':"));
  if (at == absl::string_view::npos) return std::nullopt;
  header.remove_prefix(at + key.size() + 3);
  return absl::StripLeadingAsciiWhitespace(header);
}

/// The text in quotes at the front of `rest`, which is shortened by it.
std::optional<absl::string_view> TakeQuoted(absl::string_view& rest) {
  const std::size_t begin = rest.find('\'');
  if (begin == absl::string_view::npos) return std::nullopt;
  const std::size_t end = rest.find('\'', begin + 1);
  if (end == absl::string_view::npos) return std::nullopt;
  const absl::string_view text = rest.substr(begin + 1, end - begin - 1);
  rest.remove_prefix(end + 1);
  return text;
}

/// Of a type like "<f4" or "|V3"; 0 for one that we do not know.
std::size_t SizeOf(absl::string_view type) {
  std::size_t size = 0;
  const bool is_known = type.size() >= 3 && absl::SimpleAtoi(type.substr(2), &size);
  return is_known && size <= 4096 ? size : 0;
}

/// The header's text, and where the rows begin.
absl::StatusOr<std::pair<absl::string_view, std::size_t>> HeaderOf(absl::string_view bytes) {
  constexpr std::size_t kLengthAt = 8;  // after the magic and the version
  if (bytes.size() < kLengthAt + 4 || !absl::StartsWith(bytes, kMagic)) {
    return absl::DataLossError("is no NumPy file");
  }
  const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(bytes[at]); };
  const std::size_t length_bytes = byte(6) == 1 ? 2 : 4;
  std::size_t length = 0;
  for (std::size_t i = length_bytes; i-- > 0;) length = length * 256 + byte(kLengthAt + i);
  const std::size_t begin = kLengthAt + length_bytes;
  if (length > bytes.size() - begin) {
    return absl::DataLossError(absl::StrCat("its header has ", length,
                                            " bytes; the file ends after ", bytes.size() - begin,
                                            " of them"));
  }
  return std::pair(bytes.substr(begin, length), begin + length);
}

}  // namespace

absl::StatusOr<NpyTable> NpyTable::Read(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return CannotOpen(path);
  const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  NpyTable table;
  table.path_ = path;
  const auto header = HeaderOf(bytes);
  if (!header.ok()) return FileError(path, header.status().message());
  if (absl::Status status = table.TakeHeader(header->first); !status.ok()) {
    return FileError(path, status.message());
  }
  table.rows_ = bytes.substr(header->second);
  // Divided, as a product of damaged numbers may overflow.
  const bool fits = table.rows_.size() % table.row_bytes_ == 0 &&
                    table.rows_.size() / table.row_bytes_ == table.row_count_;
  if (fits) return table;
  return FileError(path,
                   absl::StrCat("has ", table.rows_.size(), " bytes of rows; ", table.row_count_,
                                " rows of ", table.row_bytes_, " bytes are announced"));
}

absl::Status NpyTable::TakeHeader(absl::string_view header) {
  const auto order = After(header, "fortran_order");
  const auto shape = After(header, "shape");
  const auto description = After(header, "descr");
  if (!order || !shape || !description) {
    return absl::DataLossError("its header does not tell descr, fortran_order and shape");
  }
  if (!absl::StartsWith(*order, "False")) {
    return absl::DataLossError(
        "fortran_order is not False: columns one after the other are not read");
  }
  const absl::string_view extent = shape->substr(0, shape->find(')') + 1);
  absl::string_view count = extent;
  const bool is_row = absl::ConsumePrefix(&count, "(") && absl::ConsumeSuffix(&count, ",)");
  if (!is_row || !absl::SimpleAtoi(count, &row_count_)) {
    return absl::DataLossError(absl::StrCat("shape is ", extent, "; it must have one dimension"));
  }
  return TakeFields(*description);
}

absl::Status NpyTable::TakeFields(absl::string_view description) {
  if (!absl::StartsWith(description, "[")) {
    return absl::DataLossError(absl::StrCat("descr is ",
                                            description.substr(0, description.find(',')),
                                            "; it must be a list of named fields"));
  }
  absl::string_view rest = description.substr(0, description.find(']'));
  while (absl::StrContains(rest, '(')) {
    const auto name = TakeQuoted(rest);
    const auto type = TakeQuoted(rest);
    if (!name || !type || SizeOf(*type) == 0) {
      return absl::DataLossError(absl::StrCat("descr has a field \"", name.value_or(""),
                                              "\" of the type '", type.value_or(""), "'"));
    }
    fields_[std::string(*name)] = {std::string(*type), row_bytes_};
    row_bytes_ += SizeOf(*type);
  }
  if (row_bytes_ == 0) return absl::DataLossError("descr has no field");
  return absl::OkStatus();
}

absl::StatusOr<std::size_t> NpyTable::OffsetOf(absl::string_view name,
                                               absl::string_view type) const {
  const auto field = fields_.find(name);
  if (field == fields_.end()) {
    const auto each = [](std::string* out, const auto& entry) { *out += entry.first; };
    return FileError(path_, absl::StrCat("has no field \"", name, "\"; its fields are ",
                                         absl::StrJoin(fields_, ", ", each)));
  }
  if (field->second.type == type) return field->second.offset;
  return FileError(path_, absl::StrCat("field \"", name, "\" is of type '", field->second.type,
                                       "'; it must be '", type, "'"));
}

}  // namespace dcloc
