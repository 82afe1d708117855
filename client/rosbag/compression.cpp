#include "client/rosbag/compression.h"

#include <bzlib.h>
#include <lz4frame.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"

namespace dcloc::rosbag {
namespace {

constexpr std::size_t kUnpackedAtOnce = std::size_t{64} << 10U;
constexpr const char* kEndsElsewhere = "it does not end where its header says";

absl::Status Damaged(Compression compression, absl::string_view why) {
  return absl::DataLossError(
      absl::StrCat("a chunk packed with ", NameOf(compression), " is damaged: ", why));
}

absl::StatusOr<std::string> CompressBz2(absl::string_view bytes) {
  // bzip2's own bound for what does not shrink.
  std::string packed(bytes.size() + bytes.size() / 100 + 600, '\0');
  auto size = static_cast<unsigned int>(packed.size());
  std::string source(bytes);  // the interface takes no const
  const int result = BZ2_bzBuffToBuffCompress(packed.data(), &size, source.data(),
                                              static_cast<unsigned int>(source.size()), 9, 0, 0);
  if (result != BZ_OK) return absl::InternalError(absl::StrCat("bzip2 failed: ", result));
  packed.resize(size);
  return packed;
}

absl::StatusOr<std::string> CompressLz4(absl::string_view bytes) {
  LZ4F_preferences_t preferences = LZ4F_INIT_PREFERENCES;
  preferences.frameInfo.blockMode = LZ4F_blockIndependent;
  preferences.frameInfo.contentChecksumFlag = LZ4F_contentChecksumEnabled;
  std::string packed(LZ4F_compressFrameBound(bytes.size(), &preferences), '\0');
  const std::size_t size =
      LZ4F_compressFrame(packed.data(), packed.size(), bytes.data(), bytes.size(), &preferences);
  if (LZ4F_isError(size) != 0U) {
    return absl::InternalError(absl::StrCat("lz4 failed: ", LZ4F_getErrorName(size)));
  }
  packed.resize(size);
  return packed;
}

/// What could be unpacked, and why no more where that is not all.
struct Unpacked {
  std::string bytes;
  absl::Status status;
};

/// At most `max_size` bytes.
Unpacked UnpackBz2(absl::string_view packed, std::size_t max_size) {
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) {
    return {"", absl::ResourceExhaustedError("bzip2 has no memory")};
  }
  const std::unique_ptr<bz_stream, decltype(&BZ2_bzDecompressEnd)> end(&stream,
                                                                       &BZ2_bzDecompressEnd);
  std::string source(packed);  // the interface takes no const
  stream.next_in = source.data();
  stream.avail_in = static_cast<unsigned int>(source.size());
  Unpacked unpacked;
  std::string buffer(kUnpackedAtOnce, '\0');
  while (true) {
    stream.next_out = buffer.data();
    stream.avail_out = static_cast<unsigned int>(buffer.size());
    const int result = BZ2_bzDecompress(&stream);
    const std::size_t given = buffer.size() - stream.avail_out;
    unpacked.bytes.append(buffer, 0, given);
    if (result == BZ_STREAM_END) return unpacked;
    const bool is_stuck = given == 0 && stream.avail_in == 0;
    if (result != BZ_OK || is_stuck || unpacked.bytes.size() > max_size) {
      unpacked.status =
          Damaged(Compression::kBz2,
                  result != BZ_OK ? absl::StrCat("bzip2 error ", result) : kEndsElsewhere);
      return unpacked;
    }
  }
}

/// At most `max_size` bytes.
Unpacked UnpackLz4(absl::string_view packed, std::size_t max_size) {
  LZ4F_dctx* raw = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION)) != 0U) {
    return {"", absl::ResourceExhaustedError("lz4 has no memory")};
  }
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(
      raw, &LZ4F_freeDecompressionContext);
  Unpacked unpacked;
  std::string buffer(kUnpackedAtOnce, '\0');
  std::size_t wanted = 1;  // a hint of how many bytes come; 0 at the frame's end
  while (wanted != 0) {
    std::size_t taken = packed.size();
    std::size_t given = buffer.size();
    wanted = LZ4F_decompress(context.get(), buffer.data(), &given, packed.data(), &taken, nullptr);
    const bool has_failed = LZ4F_isError(wanted) != 0U;
    if (!has_failed) unpacked.bytes.append(buffer, 0, given);
    const bool is_stuck = wanted != 0 && taken == 0 && given == 0;
    if (has_failed || is_stuck || unpacked.bytes.size() > max_size) {
      unpacked.status =
          Damaged(Compression::kLz4, has_failed ? LZ4F_getErrorName(wanted) : kEndsElsewhere);
      return unpacked;
    }
    packed.remove_prefix(taken);
  }
  return unpacked;
}

Unpacked Unpack(absl::string_view packed, Compression compression, std::size_t max_size) {
  switch (compression) {
    case Compression::kNone:
      return {std::string(packed), absl::OkStatus()};
    case Compression::kBz2:
      return UnpackBz2(packed, max_size);
    case Compression::kLz4:
      return UnpackLz4(packed, max_size);
  }
  return {"", absl::InvalidArgumentError("compression is none of Compression")};
}

}  // namespace

absl::string_view NameOf(Compression compression) {
  switch (compression) {
    case Compression::kNone:
      return "none";
    case Compression::kBz2:
      return "bz2";
    case Compression::kLz4:
      return "lz4";
  }
  return "unknown";
}

absl::StatusOr<Compression> CompressionByName(absl::string_view name) {
  for (const Compression known : {Compression::kNone, Compression::kBz2, Compression::kLz4}) {
    if (name == NameOf(known)) return known;
  }
  return absl::InvalidArgumentError(
      absl::StrCat("compression is '", name, "'; it must be none, bz2 or lz4"));
}

absl::StatusOr<std::string> Compress(absl::string_view bytes, Compression compression) {
  switch (compression) {
    case Compression::kNone:
      return std::string(bytes);
    case Compression::kBz2:
      return CompressBz2(bytes);
    case Compression::kLz4:
      return CompressLz4(bytes);
  }
  return absl::InvalidArgumentError("compression is none of Compression");
}

absl::StatusOr<std::string> Decompress(absl::string_view packed, Compression compression,
                                       std::size_t size) {
  Unpacked unpacked = Unpack(packed, compression, size);
  if (!unpacked.status.ok()) return unpacked.status;
  if (unpacked.bytes.size() != size) {
    return Damaged(compression, "it is not as long as its header says");
  }
  return std::move(unpacked.bytes);
}

std::string DecompressCut(absl::string_view packed, Compression compression, std::size_t max_size) {
  std::string bytes = Unpack(packed, compression, max_size).bytes;
  bytes.resize(std::min(bytes.size(), max_size));
  return bytes;
}

}  // namespace dcloc::rosbag
