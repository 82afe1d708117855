#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client/rosbag/compression.h"
#include "client/rosbag/message_types.h"
#include "core/radar/stamp.h"

namespace dcloc::rosbag {

/// Writes a bag (format 2.0) with its index, as ROS's own tools read it. Not thread-safe.
class BagWriter {
 public:
  /// Begins the file; an existing one is replaced. Errors name the path and the reason.
  static absl::StatusOr<BagWriter> Create(const std::filesystem::path& path,
                                          Compression compression);

  /// Adds a message of a type that has a definition (`DefinitionOf`); a topic has one type. What
  /// cannot be written shows in `Close`. InvalidArgument for a stamp outside of 1970 to 2106.
  absl::Status Add(const std::string& topic, const MessageType& type, Stamp record_time,
                   absl::string_view data);

  /// Writes the index and ends the file; without it the bag counts as one without index.
  absl::Status Close();

 private:
  /// Where a message of a connection lies in a chunk.
  using Entry = std::pair<Stamp, std::uint32_t>;
  struct ChunkInfo {
    std::uint64_t position = 0;
    Stamp begin = Stamp::max();
    Stamp end = Stamp::min();
    std::map<std::uint32_t, std::vector<Entry>> entries;  ///< by connection
  };

  BagWriter(std::filesystem::path path, std::ofstream file, Compression compression)
      : path_(std::move(path)), file_(std::move(file)), compression_(compression) {}

  std::uint32_t ConnectionOf(const std::string& topic, const MessageType& type);
  absl::Status EndChunk();
  void WriteIndex(const ChunkInfo& chunk);
  void WriteBagHeader(std::uint64_t index_position);

  std::filesystem::path path_;
  std::ofstream file_;
  Compression compression_;
  std::map<std::string, std::uint32_t> connection_ids_;  ///< by topic
  std::vector<std::string> connections_;                 ///< their records, by id
  std::string chunk_;                                    ///< not yet packed
  ChunkInfo chunk_info_;
  std::vector<ChunkInfo> chunks_;
};

}  // namespace dcloc::rosbag
