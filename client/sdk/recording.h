#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "dcloc/v1/recording.pb.h"

namespace dcloc::client {

/// The format that is written, and the newest that is read.
inline constexpr int kRecordingFormatVersion = 2;

/// Writes a session to a file (see recording.proto) as it goes on. Not thread-safe.
class RecordingWriter {
 public:
  /// Begins the file; an existing one is replaced. Sets the format version of `header` and removes
  /// its secrets. Errors name the path and the reason.
  static absl::StatusOr<RecordingWriter> Create(const std::filesystem::path& path,
                                                v1::RecordingHeader header);

  /// Goes to the system when a buffer is full; what cannot be written shows in `Close`.
  void Add(const v1::RecordedScan& scan);
  void Add(const v1::RecordedFix& fix);

  /// Ends the file, saying why. Without it the file counts as cut off. Errors as above.
  absl::Status Close(const std::string& reason);

  std::int64_t scan_count() const { return scan_count_; }

 private:
  RecordingWriter(std::filesystem::path path, std::ofstream file);
  void Write(absl::string_view bytes);
  void Write(const google::protobuf::MessageLite& message);

  std::filesystem::path path_;
  std::ofstream file_;
  std::uint32_t crc32_ = 0;
  std::int64_t scan_count_ = 0;
  std::int64_t fix_count_ = 0;
};

/// Reads such a file. Errors name the path: NotFound and the like, InvalidArgument for what is no
/// recording or of a newer format, DataLoss where it is cut off or damaged, and where. Not
/// thread-safe.
class RecordingReader {
 public:
  static absl::StatusOr<RecordingReader> Open(const std::filesystem::path& path);

  const v1::RecordingHeader& header() const { return header_; }

  /// The next `scan` or `fix`; nothing after the last one, when the file has been found to be
  /// whole.
  absl::StatusOr<std::optional<v1::RecordingEntry>> Next();

  /// Why the recording ended, once `Next` gave nothing.
  const std::string& end_reason() const { return end_reason_; }

 private:
  explicit RecordingReader(std::filesystem::path path) : path_(std::move(path)) {}

  absl::Status ReadHeader();
  absl::Status ReadMessage(google::protobuf::MessageLite* message);
  absl::Status CheckEnd(const v1::RecordingEnd& end, std::uint32_t crc_before);
  absl::Status Damaged(absl::string_view what) const;

  std::filesystem::path path_;
  std::ifstream file_;
  v1::RecordingHeader header_;
  std::string bytes_;  ///< of the message that is being read
  std::string end_reason_;
  std::uint32_t crc32_ = 0;
  std::int64_t offset_ = 0;
  std::int64_t scan_count_ = 0;
  std::int64_t fix_count_ = 0;
  bool ended_ = false;
};

}  // namespace dcloc::client
