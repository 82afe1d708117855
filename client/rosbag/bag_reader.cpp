#include "client/rosbag/bag_reader.h"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <map>
#include <optional>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client/rosbag/bag_bytes.h"
#include "client/rosbag/compression.h"

namespace dcloc::rosbag {
namespace {

// rosbag makes chunks of less than 1 MB; a message larger than that has a chunk of its own.
constexpr std::size_t kMaxChunkBytes = std::size_t{512} << 20U;
constexpr std::size_t kMaxHeaderBytes = std::size_t{16} << 20U;

// Kinds of records.
enum class Op : unsigned char {
  kMessage = 0x02,
  kBagHeader = 0x03,
  kIndex = 0x04,
  kChunk = 0x05,
  kChunkInfo = 0x06,
  kConnection = 0x07,
};

struct Record {
  HeaderFields header;
  std::string data;

  Op op() const {
    const auto field = header.find("op");
    const bool is_op = field != header.end() && field->second.size() == 1;
    return is_op ? static_cast<Op>(field->second[0]) : Op{};
  }
};

/// Reads one bag from its first record to its last.
class Reader {
 public:
  Reader(std::ifstream& file, std::int64_t size,
         const std::function<absl::Status(const Message&)>& visit)
      : file_(file),
        left_(size - static_cast<std::int64_t>(kBagMagic.size())),
        size_(size),
        visit_(visit) {}

  absl::StatusOr<BagSummary> Read() {
    while (left_ > 0) {
      const std::int64_t begin = size_ - left_;
      absl::StatusOr<std::optional<Record>> record = NextRecord();
      absl::Status status = record.status();
      if (status.ok() && !record->has_value()) {
        summary_.cut_at = begin;
        break;
      }
      if (status.ok()) status = Take(**record);
      if (!status.ok()) {
        return absl::Status(status.code(),
                            absl::StrCat("record at byte ", begin, ": ", status.message()));
      }
    }
    return std::move(summary_);
  }

 private:
  /// Nothing where the file ends within the record.
  absl::StatusOr<std::optional<Record>> NextRecord() {
    std::string header;
    Record record;
    if (!ReadBlock(header, kMaxHeaderBytes)) return std::nullopt;
    absl::StatusOr<HeaderFields> fields = ParseHeader(header);
    if (!fields.ok()) return fields.status();
    record.header = *std::move(fields);
    const bool is_whole = ReadBlock(record.data, kMaxChunkBytes);
    if (is_whole && !IsUnfinished(record)) return record;
    // Of a chunk that is cut off, the whole messages are still there.
    if (record.op() == Op::kChunk) {
      if (absl::Status status = TakeRestOfFile(record); !status.ok()) return status;
    }
    return std::nullopt;
  }

  /// A recorder writes how long a packed chunk is once it has ended. What is not packed follows as
  /// records.
  bool IsUnfinished(Record& record) const {
    return record.op() == Op::kChunk && record.data.empty() && left_ > 0 &&
           record.header["compression"] != NameOf(Compression::kNone);
  }

  absl::Status TakeRestOfFile(Record& record) {
    const std::string& name = record.header["compression"];
    const auto compression = CompressionByName(name);
    if (!compression.ok()) return compression.status();
    record.data.resize(static_cast<std::size_t>(
        std::clamp<std::int64_t>(left_, 0, static_cast<std::int64_t>(kMaxChunkBytes))));
    file_.read(record.data.data(), static_cast<std::streamsize>(record.data.size()));
    summary_.compressions.insert(name);
    return TakeMessages(DecompressCut(record.data, *compression, kMaxChunkBytes), /*is_cut=*/true);
  }

  /// A length and so many bytes; false where the file has not so many.
  bool ReadBlock(std::string& bytes, std::size_t max_size) {
    std::uint32_t size = 0;
    if (left_ < static_cast<std::int64_t>(sizeof(size))) return false;
    file_.read(reinterpret_cast<char*>(&size), sizeof(size));
    left_ -= sizeof(size);
    if (size > left_ || size > max_size) return false;
    bytes.resize(size);
    file_.read(bytes.data(), size);
    left_ -= size;
    return file_.good();
  }

  absl::Status Take(const Record& record) {
    switch (record.op()) {
      case Op::kBagHeader:
        return TakeBagHeader(record);
      case Op::kChunk:
        return TakeChunk(record);
      case Op::kConnection:
        return TakeConnection(record.header, record.data);
      case Op::kMessage:
        return TakeMessage(record.header, record.data);
      case Op::kIndex:
      case Op::kChunkInfo:
        return absl::OkStatus();
    }
    return absl::DataLossError("is of no kind that bags have");
  }

  absl::Status TakeBagHeader(const Record& record) {
    const auto index = NumberOf<std::uint64_t>(record.header, "index_pos");
    if (!index.ok()) return index.status();
    summary_.has_index = *index != 0;
    const auto encryptor = record.header.find("encryptor");
    if (encryptor == record.header.end() || encryptor->second.empty()) return absl::OkStatus();
    return absl::UnimplementedError(
        absl::StrCat("the bag is encrypted by ", encryptor->second, "; decrypt it first"));
  }

  absl::Status TakeChunk(const Record& record) {
    const auto name = record.header.find("compression");
    if (name == record.header.end()) return absl::DataLossError("a chunk names no compression");
    const auto compression = CompressionByName(name->second);
    if (!compression.ok()) return compression.status();
    const auto size = NumberOf<std::uint32_t>(record.header, "size");
    if (!size.ok()) return size.status();
    if (*size > kMaxChunkBytes) {
      return absl::DataLossError(
          absl::StrCat("a chunk has ", *size, " bytes; at most ", kMaxChunkBytes, " are read"));
    }
    summary_.compressions.insert(name->second);
    if (*compression == Compression::kNone) return TakeMessages(record.data, /*is_cut=*/false);
    const absl::StatusOr<std::string> bytes = Decompress(record.data, *compression, *size);
    if (!bytes.ok()) return bytes.status();
    return TakeMessages(*bytes, /*is_cut=*/false);
  }

  absl::Status TakeMessages(absl::string_view bytes, bool is_cut) {
    ByteReader reader(bytes);
    while (!reader.rest().empty()) {
      const absl::string_view header_bytes = reader.TakeText();
      const absl::string_view data = reader.TakeText();
      if (!reader.ok()) {
        return is_cut ? absl::OkStatus() : absl::DataLossError("a chunk ends within a message");
      }
      absl::StatusOr<HeaderFields> header = ParseHeader(header_bytes);
      if (!header.ok()) return header.status();
      const std::string& op = (*header)["op"];
      const Op kind = op.size() == 1 ? static_cast<Op>(op[0]) : Op{};
      absl::Status status = kind == Op::kConnection ? TakeConnection(*header, data)
                            : kind == Op::kMessage
                                ? TakeMessage(*header, data)
                                : absl::DataLossError("a chunk holds what is no message");
      if (!status.ok()) return status;
    }
    return absl::OkStatus();
  }

  absl::Status TakeConnection(const HeaderFields& header, absl::string_view data) {
    const auto id = NumberOf<std::uint32_t>(header, "conn");
    if (!id.ok()) return id.status();
    absl::StatusOr<HeaderFields> fields = ParseHeader(data);
    if (!fields.ok()) return fields.status();
    const auto topic = header.find("topic");
    // The record's topic is the one recorded; its data may name what it was mapped from.
    connections_.try_emplace(
        *id, Connection{.topic = topic == header.end() ? (*fields)["topic"] : topic->second,
                        .type = (*fields)["type"],
                        .md5sum = (*fields)["md5sum"]});
    return absl::OkStatus();
  }

  absl::Status TakeMessage(const HeaderFields& header, absl::string_view data) {
    const auto id = NumberOf<std::uint32_t>(header, "conn");
    if (!id.ok()) return id.status();
    const auto connection = connections_.find(*id);
    if (connection == connections_.end()) {
      return absl::DataLossError(
          absl::StrCat("a message is of connection ", *id, ", which nothing before it describes"));
    }
    const auto time = header.find("time");
    if (time == header.end() || time->second.size() != 8) {
      return absl::DataLossError("a message has no valid time");
    }
    ++summary_.message_count;
    return visit_({connection->second, ByteReader(time->second).TakeTime(), data});
  }

  std::ifstream& file_;
  std::int64_t left_;
  const std::int64_t size_;
  const std::function<absl::Status(const Message&)>& visit_;
  std::map<std::uint32_t, Connection> connections_;
  BagSummary summary_;
};

absl::Status CheckMagic(absl::string_view magic) {
  if (magic == kBagMagic) return absl::OkStatus();
  if (absl::StartsWith(magic, "\x89MCAP")) {
    return absl::InvalidArgumentError(
        "is an MCAP file; only bags of ROS 1 (format 2.0) are read: convert it first");
  }
  if (absl::StartsWith(magic, "SQLite form")) {
    return absl::InvalidArgumentError(
        "is a bag of ROS 2; only bags of ROS 1 (format 2.0) are read: convert it first");
  }
  if (absl::StartsWith(magic, "#ROSBAG V")) {
    return absl::InvalidArgumentError(
        absl::StrCat("is of format ", magic.substr(9, 3), "; `rosbag fix` brings it to 2.0"));
  }
  return absl::InvalidArgumentError("is no bag: it does not begin with #ROSBAG V2.0");
}

}  // namespace

absl::StatusOr<BagSummary> ReadBag(const std::filesystem::path& path,
                                   const std::function<absl::Status(const Message&)>& visit) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) return absl::ErrnoToStatus(error.value(), path.string());
  std::ifstream file(path, std::ios::binary);
  if (!file) return absl::ErrnoToStatus(errno, path.string());
  std::string magic(kBagMagic.size(), '\0');
  file.read(magic.data(), static_cast<std::streamsize>(magic.size()));
  magic.resize(static_cast<std::size_t>(file.gcount()));
  absl::Status status = CheckMagic(magic);
  if (status.ok()) {
    absl::StatusOr<BagSummary> summary =
        Reader(file, static_cast<std::int64_t>(size), visit).Read();
    if (summary.ok()) return summary;
    status = summary.status();
  }
  return absl::Status(status.code(), absl::StrCat(path.string(), ": ", status.message()));
}

}  // namespace dcloc::rosbag
