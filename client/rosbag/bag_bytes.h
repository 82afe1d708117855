#pragma once

#include <cstdint>
#include <cstring>
#include <map>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/radar/stamp.h"

namespace dcloc::rosbag {

/// How a bag of format 2.0 begins.
inline constexpr absl::string_view kBagMagic = "#ROSBAG V2.0\n";

/// Takes little-endian values from the front of bytes. Beyond their end it gives zeros and empty
/// text, and says so in `ok`; so a reader can take all fields and look once.
class ByteReader {
 public:
  explicit ByteReader(absl::string_view bytes) : rest_(bytes) {}

  bool ok() const { return ok_; }
  absl::string_view rest() const { return rest_; }

  template <typename Number>
  Number Take() {
    Number value{};
    const absl::string_view bytes = TakeBytes(sizeof(Number));
    if (ok_) std::memcpy(&value, bytes.data(), sizeof(Number));
    return value;
  }

  absl::string_view TakeBytes(std::size_t count) {
    ok_ = ok_ && count <= rest_.size();
    if (!ok_) return {};
    const absl::string_view bytes = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return bytes;
  }

  /// A length of 32 bits, and so many bytes.
  absl::string_view TakeText() { return TakeBytes(Take<std::uint32_t>()); }

  /// Seconds and nanoseconds of 32 bits each.
  Stamp TakeTime();

 private:
  absl::string_view rest_;
  bool ok_ = true;
};

/// The same values, written.
template <typename Number>
void AppendNumber(std::string& bytes, Number value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(Number));
}
void AppendText(std::string& bytes, absl::string_view text);
/// Of a stamp from 1970 to 2106, which 32 bits hold.
void AppendTime(std::string& bytes, Stamp stamp);

/// The fields of a record's or a connection's header, `name=value` with a length each.
using HeaderFields = std::map<std::string, std::string, std::less<>>;

/// DataLoss where the bytes are no such header.
absl::StatusOr<HeaderFields> ParseHeader(absl::string_view bytes);
std::string FormatHeader(const HeaderFields& fields);

/// A field's number; DataLoss where it is missing or of another size.
template <typename Number>
absl::StatusOr<Number> NumberOf(const HeaderFields& fields, absl::string_view name) {
  const auto field = fields.find(name);
  if (field == fields.end() || field->second.size() != sizeof(Number)) {
    return absl::DataLossError("a record's header has no valid field " + std::string(name));
  }
  return ByteReader(field->second).Take<Number>();
}

}  // namespace dcloc::rosbag
