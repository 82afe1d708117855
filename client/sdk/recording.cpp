#include "client/sdk/recording.h"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/message_lite.h>
#include <zlib.h>

#include <array>
#include <cerrno>
#include <utility>

#include "absl/strings/str_cat.h"

namespace dcloc::client {
namespace {

constexpr absl::string_view kMagic = "DCLOCREC";
/// Far above the largest scan, and little enough to be read for nothing.
constexpr std::uint32_t kMaxRecorded_bytes = 64U << 20;
constexpr int kMaxVarint_bytes = 5;

std::uint32_t Crc32(std::uint32_t crc, absl::string_view bytes) {
  return static_cast<std::uint32_t>(
      crc32(crc, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
}

absl::Status FileError(const std::filesystem::path& path) {
  return absl::ErrnoToStatus(errno == 0 ? EIO : errno, path.string());
}

}  // namespace

// ---- Writing

absl::StatusOr<RecordingWriter> RecordingWriter::Create(const std::filesystem::path& path,
                                                        v1::RecordingHeader header) {
  errno = 0;
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  if (!file) return FileError(path);
  header.set_format_version(kRecordingFormatVersion);
  header.mutable_open()->clear_resume_token();
  header.mutable_opened()->clear_resume_token();
  RecordingWriter writer(path, std::move(file));
  writer.Write(kMagic);
  writer.Write(header);
  return writer;
}

RecordingWriter::RecordingWriter(std::filesystem::path path, std::ofstream file)
    : path_(std::move(path)), file_(std::move(file)) {}

void RecordingWriter::Write(absl::string_view bytes) {
  crc32_ = Crc32(crc32_, bytes);
  file_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

void RecordingWriter::Write(const google::protobuf::MessageLite& message) {
  const std::string bytes = message.SerializeAsString();
  std::array<std::uint8_t, kMaxVarint_bytes> size{};
  const std::uint8_t* end = google::protobuf::io::CodedOutputStream::WriteVarint32ToArray(
      static_cast<std::uint32_t>(bytes.size()), size.data());
  Write(absl::string_view(reinterpret_cast<const char*>(size.data()),
                          static_cast<std::size_t>(end - size.data())));
  Write(absl::string_view(bytes));
}

void RecordingWriter::Add(const v1::RecordedScan& scan) {
  v1::RecordingEntry entry;
  *entry.mutable_scan() = scan;
  Write(entry);
  ++scan_count_;
}

void RecordingWriter::Add(const v1::RecordedFix& fix) {
  v1::RecordingEntry entry;
  *entry.mutable_fix() = fix;
  Write(entry);
  ++fix_count_;
}

absl::Status RecordingWriter::Close(const std::string& reason) {
  v1::RecordingEntry entry;
  entry.mutable_end()->set_scan_count(scan_count_);
  entry.mutable_end()->set_fix_count(fix_count_);
  entry.mutable_end()->set_reason(reason);
  entry.mutable_end()->set_crc32(Crc32(crc32_, reason));
  Write(entry);
  errno = 0;
  file_.close();
  return file_ ? absl::OkStatus() : FileError(path_);
}

// ---- Reading

absl::StatusOr<RecordingReader> RecordingReader::Open(const std::filesystem::path& path) {
  RecordingReader reader(path);
  if (absl::Status status = reader.ReadHeader(); !status.ok()) return status;
  return reader;
}

absl::Status RecordingReader::ReadHeader() {
  errno = 0;
  file_.open(path_, std::ios::binary);
  if (!file_) return FileError(path_);
  std::array<char, kMagic.size()> magic{};
  file_.read(magic.data(), magic.size());
  if (absl::string_view(magic.data(), magic.size()) != kMagic) {
    return absl::InvalidArgumentError(absl::StrCat(path_.string(), ": is no dcloc recording"));
  }
  offset_ = kMagic.size();
  crc32_ = Crc32(crc32_, kMagic);
  if (absl::Status status = ReadMessage(&header_); !status.ok()) return status;
  if (header_.format_version() >= 1 && header_.format_version() <= kRecordingFormatVersion) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat(path_.string(), ": has format version ", header_.format_version(),
                   "; this program reads 1 to ", kRecordingFormatVersion, ". It was recorded by ",
                   header_.program()));
}

absl::Status RecordingReader::Damaged(absl::string_view what) const {
  return absl::DataLossError(absl::StrCat(path_.string(), ": ", what, " at byte ", offset_,
                                          ", after ", scan_count_, " scans"));
}

absl::Status RecordingReader::ReadMessage(google::protobuf::MessageLite* message) {
  std::uint32_t size = 0;
  bytes_.clear();
  for (int i = 0;; ++i) {
    const int byte = file_.get();
    if (byte == std::char_traits<char>::eof()) return Damaged("is cut off");
    if (i == kMaxVarint_bytes) return Damaged("is damaged");
    bytes_.push_back(static_cast<char>(byte));
    size |= (static_cast<std::uint32_t>(byte) & 0x7FU) << (7 * i);
    if ((byte & 0x80) == 0) break;
  }
  if (size > kMaxRecorded_bytes) return Damaged("is damaged");
  const std::size_t prefix = bytes_.size();
  bytes_.resize(prefix + size);
  file_.read(bytes_.data() + prefix, static_cast<std::streamsize>(size));
  if (static_cast<std::uint32_t>(file_.gcount()) != size) return Damaged("is cut off");
  if (!message->ParseFromArray(bytes_.data() + prefix, static_cast<int>(size))) {
    return Damaged("is damaged");
  }
  offset_ += static_cast<std::int64_t>(bytes_.size());
  crc32_ = Crc32(crc32_, bytes_);
  return absl::OkStatus();
}

absl::StatusOr<std::optional<v1::RecordingEntry>> RecordingReader::Next() {
  if (ended_) return std::nullopt;
  const std::uint32_t crc32_before = crc32_;
  v1::RecordingEntry entry;
  if (absl::Status status = ReadMessage(&entry); !status.ok()) return status;
  if (entry.has_scan() || entry.has_fix()) {
    ++(entry.has_scan() ? scan_count_ : fix_count_);
    return entry;
  }
  if (absl::Status status = CheckEnd(entry.end(), crc32_before); !status.ok()) return status;
  ended_ = true;
  end_reason_ = entry.end().reason();
  return std::nullopt;
}

absl::Status RecordingReader::CheckEnd(const v1::RecordingEnd& end, std::uint32_t crc_before) {
  if (end.scan_count() != scan_count_ || end.fix_count() != fix_count_ ||
      end.crc32() != static_cast<std::int64_t>(Crc32(crc_before, end.reason()))) {
    return Damaged("is damaged: its end does not fit what is before it");
  }
  if (file_.get() != std::char_traits<char>::eof()) return Damaged("goes on behind its end");
  return absl::OkStatus();
}

}  // namespace dcloc::client
