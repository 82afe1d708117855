#pragma once

#include <cstddef>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace dcloc::rosbag {

/// How the chunks of a bag are packed.
enum class Compression { kNone, kBz2, kLz4 };

/// "none", "bz2", "lz4", as bags name them.
absl::string_view NameOf(Compression compression);

/// InvalidArgument names what is none of them.
absl::StatusOr<Compression> CompressionByName(absl::string_view name);

/// A chunk's bytes. lz4 is packed as ROS's own reader takes it: independent blocks and a checksum.
absl::StatusOr<std::string> Compress(absl::string_view bytes, Compression compression);

/// The `size` bytes that `packed` stands for. DataLoss when it is damaged, or of another size.
absl::StatusOr<std::string> Decompress(absl::string_view packed, Compression compression,
                                       std::size_t size);

/// What can be unpacked of bytes that are cut off, at most `max_size` bytes: of lz4 all blocks that
/// are whole, of bz2 too, whose blocks have 900 kB.
std::string DecompressCut(absl::string_view packed, Compression compression, std::size_t max_size);

}  // namespace dcloc::rosbag
