#include "client/rosbag/bag_bytes.h"

#include <bit>
#include <chrono>

namespace dcloc::rosbag {

static_assert(std::endian::native == std::endian::little, "bags are little-endian");

namespace {
constexpr std::int64_t kPerSecond = 1'000'000'000;
}  // namespace

Stamp ByteReader::TakeTime() {
  const auto seconds = Take<std::uint32_t>();
  const auto nanoseconds = Take<std::uint32_t>();
  return Stamp(std::chrono::nanoseconds(kPerSecond * seconds + nanoseconds));
}

void AppendText(std::string& bytes, absl::string_view text) {
  AppendNumber(bytes, static_cast<std::uint32_t>(text.size()));
  bytes.append(text.data(), text.size());
}

void AppendTime(std::string& bytes, Stamp stamp) {
  const std::int64_t nanoseconds = stamp.time_since_epoch().count();
  AppendNumber(bytes, static_cast<std::uint32_t>(nanoseconds / kPerSecond));
  AppendNumber(bytes, static_cast<std::uint32_t>(nanoseconds % kPerSecond));
}

absl::StatusOr<HeaderFields> ParseHeader(absl::string_view bytes) {
  HeaderFields fields;
  ByteReader reader(bytes);
  while (!reader.rest().empty()) {
    const absl::string_view field = reader.TakeText();
    const std::size_t equals = field.find('=');
    if (!reader.ok() || equals == absl::string_view::npos) {
      return absl::DataLossError("a record's header is damaged");
    }
    fields[std::string(field.substr(0, equals))] = std::string(field.substr(equals + 1));
  }
  return fields;
}

std::string FormatHeader(const HeaderFields& fields) {
  std::string bytes;
  for (const auto& [name, value] : fields) AppendText(bytes, name + "=" + value);
  return bytes;
}

}  // namespace dcloc::rosbag
