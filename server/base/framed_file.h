#pragma once

#include <google/protobuf/message_lite.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

/// Files of messages, each behind its size in 4 bytes, low byte first.
namespace dcloc::server {

/// Appends a message behind its size.
void AppendFramed(const google::protobuf::MessageLite& message, std::string* bytes);

/// Reads such a file, and removes it at its end. DataLoss: it is cut off, damaged or gone. Not
/// thread-safe.
class FramedReader {
 public:
  explicit FramedReader(std::filesystem::path path) : path_(std::move(path)) {}
  ~FramedReader();
  FramedReader(const FramedReader&) = delete;
  FramedReader& operator=(const FramedReader&) = delete;

  /// To the first message, or to where `position` was told.
  absl::Status Begin(std::int64_t position = 0);

  /// Where the next message begins.
  std::int64_t position() const { return position_; }

  /// False after the last one.
  absl::StatusOr<bool> Next(google::protobuf::MessageLite* message);

 private:
  const std::filesystem::path path_;
  std::ifstream in_;
  std::string buffer_;
  std::int64_t position_ = 0;
};

}  // namespace dcloc::server
