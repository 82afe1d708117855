#include "client/rosbag/bag_writer.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <limits>

#include "absl/strings/str_cat.h"
#include "client/rosbag/bag_bytes.h"

namespace dcloc::rosbag {
namespace {

constexpr std::size_t kChunkBytes = std::size_t{768} << 10U;  // as rosbag makes them
constexpr std::size_t kBagHeaderBytes = 4096;

template <typename Number>
std::string Bytes(Number value) {
  std::string bytes;
  AppendNumber(bytes, value);
  return bytes;
}

std::string TimeBytes(Stamp stamp) {
  std::string bytes;
  AppendTime(bytes, stamp);
  return bytes;
}

std::string FormatRecord(const HeaderFields& header, absl::string_view data) {
  std::string bytes;
  AppendText(bytes, FormatHeader(header));
  AppendText(bytes, data);
  return bytes;
}

void WriteTo(std::ofstream& file, absl::string_view bytes) {
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace

absl::StatusOr<BagWriter> BagWriter::Create(const std::filesystem::path& path,
                                            Compression compression) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  if (!file) return absl::ErrnoToStatus(errno, path.string());
  WriteTo(file, kBagMagic);
  BagWriter writer(path, std::move(file), compression);
  writer.WriteBagHeader(0);
  return writer;
}

void BagWriter::WriteBagHeader(std::uint64_t index_position) {
  file_.seekp(static_cast<std::streamoff>(kBagMagic.size()));
  const std::string header =
      FormatHeader({{"op", "\x03"},
                    {"index_pos", Bytes(index_position)},
                    {"conn_count", Bytes(static_cast<std::uint32_t>(connections_.size()))},
                    {"chunk_count", Bytes(static_cast<std::uint32_t>(chunks_.size()))}});
  // Padded, so that it can be written again in place.
  const std::size_t used = header.size() + 2 * sizeof(std::uint32_t);
  std::string bytes;
  AppendText(bytes, header);
  AppendText(bytes, std::string(kBagHeaderBytes - used, ' '));
  WriteTo(file_, bytes);
}

std::uint32_t BagWriter::ConnectionOf(const std::string& topic, const MessageType& type) {
  const auto id = static_cast<std::uint32_t>(connections_.size());
  const auto [entry, is_new] = connection_ids_.try_emplace(topic, id);
  if (is_new) {
    const bool is_latched = topic == "/tf_static";
    HeaderFields fields = {{"topic", topic},
                           {"type", type.name},
                           {"md5sum", type.md5sum},
                           {"message_definition", DefinitionOf(type)}};
    if (is_latched) fields["latching"] = "1";
    connections_.push_back(FormatRecord({{"op", "\x07"}, {"conn", Bytes(id)}, {"topic", topic}},
                                        FormatHeader(fields)));
    chunk_ += connections_.back();
  }
  return entry->second;
}

absl::Status BagWriter::Add(const std::string& topic, const MessageType& type, Stamp record_time,
                            absl::string_view data) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(record_time.time_since_epoch());
  if (seconds.count() < 0 || seconds.count() > std::numeric_limits<std::uint32_t>::max()) {
    return absl::InvalidArgumentError(
        absl::StrCat("a stamp is ", seconds.count(), " s; ROS has those of 1970 to 2106 only"));
  }
  const std::uint32_t id = ConnectionOf(topic, type);
  chunk_info_.entries[id].emplace_back(record_time, static_cast<std::uint32_t>(chunk_.size()));
  chunk_info_.begin = std::min(chunk_info_.begin, record_time);
  chunk_info_.end = std::max(chunk_info_.end, record_time);
  chunk_ +=
      FormatRecord({{"op", "\x02"}, {"conn", Bytes(id)}, {"time", TimeBytes(record_time)}}, data);
  return chunk_.size() < kChunkBytes ? absl::OkStatus() : EndChunk();
}

absl::Status BagWriter::EndChunk() {
  if (chunk_info_.entries.empty()) return absl::OkStatus();
  const absl::StatusOr<std::string> packed = Compress(chunk_, compression_);
  if (!packed.ok()) return packed.status();
  chunk_info_.position = static_cast<std::uint64_t>(file_.tellp());
  WriteTo(file_, FormatRecord({{"op", "\x05"},
                               {"compression", std::string(NameOf(compression_))},
                               {"size", Bytes(static_cast<std::uint32_t>(chunk_.size()))}},
                              *packed));
  WriteIndex(chunk_info_);
  chunks_.push_back(std::move(chunk_info_));
  chunk_info_ = {};
  chunk_.clear();
  return absl::OkStatus();
}

void BagWriter::WriteIndex(const ChunkInfo& chunk) {
  for (const auto& [id, entries] : chunk.entries) {
    std::string data;
    for (const auto& [stamp, offset] : entries) {
      AppendTime(data, stamp);
      AppendNumber(data, offset);
    }
    WriteTo(file_, FormatRecord({{"op", "\x04"},
                                 {"ver", Bytes(std::uint32_t{1})},
                                 {"conn", Bytes(id)},
                                 {"count", Bytes(static_cast<std::uint32_t>(entries.size()))}},
                                data));
  }
}

absl::Status BagWriter::Close() {
  if (absl::Status status = EndChunk(); !status.ok()) return status;
  const auto index_position = static_cast<std::uint64_t>(file_.tellp());
  for (const std::string& connection : connections_) WriteTo(file_, connection);
  for (const ChunkInfo& chunk : chunks_) {
    std::string data;
    for (const auto& [id, entries] : chunk.entries) {
      AppendNumber(data, id);
      AppendNumber(data, static_cast<std::uint32_t>(entries.size()));
    }
    WriteTo(file_,
            FormatRecord({{"op", "\x06"},
                          {"ver", Bytes(std::uint32_t{1})},
                          {"chunk_pos", Bytes(chunk.position)},
                          {"start_time", TimeBytes(chunk.begin)},
                          {"end_time", TimeBytes(chunk.end)},
                          {"count", Bytes(static_cast<std::uint32_t>(chunk.entries.size()))}},
                         data));
  }
  WriteBagHeader(index_position);
  file_.close();
  if (file_) return absl::OkStatus();
  return absl::DataLossError(absl::StrCat(path_.string(), ": could not be written"));
}

}  // namespace dcloc::rosbag
