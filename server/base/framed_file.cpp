#include "server/base/framed_file.h"

#include <bit>
#include <system_error>

namespace dcloc::server {
namespace {

using FrameSize = std::uint32_t;
static_assert(std::endian::native == std::endian::little);

/// Above any message that a server takes.
constexpr FrameSize kMaxFrameSize = FrameSize{1} << 30;

absl::Status FileDamaged() {
  return absl::DataLossError("the file of messages is cut off or damaged");
}

}  // namespace

void AppendFramed(const google::protobuf::MessageLite& message, std::string* bytes) {
  const auto size = static_cast<FrameSize>(message.ByteSizeLong());
  bytes->append(reinterpret_cast<const char*>(&size), sizeof(size));
  message.AppendToString(bytes);
}

FramedReader::~FramedReader() {
  std::error_code error;
  std::filesystem::remove(path_, error);
}

absl::Status FramedReader::Begin(std::int64_t position) {
  if (!in_.is_open()) in_.open(path_, std::ios::binary);
  in_.clear();
  in_.seekg(position);
  position_ = position;
  return in_ ? absl::OkStatus() : FileDamaged();
}

absl::StatusOr<bool> FramedReader::Next(google::protobuf::MessageLite* message) {
  FrameSize size = 0;
  in_.read(reinterpret_cast<char*>(&size), sizeof(size));
  if (in_.eof() && in_.gcount() == 0) return false;
  if (!in_ || size > kMaxFrameSize) return FileDamaged();
  buffer_.resize(size);
  in_.read(buffer_.data(), size);
  if (!in_ || !message->ParseFromString(buffer_)) return FileDamaged();
  position_ += static_cast<std::int64_t>(sizeof(size) + size);
  return true;
}

}  // namespace dcloc::server
