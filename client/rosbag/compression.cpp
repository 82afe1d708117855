#include "client/rosbag/compression.h"

#include <bzlib.h>
#include <lz4frame.h>

#include <memory>

#include "absl/strings/str_cat.h"

namespace dcloc::rosbag {
namespace {

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

absl::StatusOr<std::string> DecompressBz2(absl::string_view packed, std::size_t size) {
  std::string bytes(size, '\0');
  auto written = static_cast<unsigned int>(size);
  std::string source(packed);
  const int result = BZ2_bzBuffToBuffDecompress(bytes.data(), &written, source.data(),
                                                static_cast<unsigned int>(source.size()), 0, 0);
  if (result != BZ_OK) return Damaged(Compression::kBz2, absl::StrCat("bzip2 error ", result));
  if (written != size) return Damaged(Compression::kBz2, "it is shorter than its header says");
  return bytes;
}

absl::StatusOr<std::string> DecompressLz4(absl::string_view packed, std::size_t size) {
  LZ4F_dctx* raw = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION)) != 0U) {
    return absl::ResourceExhaustedError("lz4 has no memory");
  }
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(
      raw, &LZ4F_freeDecompressionContext);
  std::string bytes(size, '\0');
  std::size_t written = 0;
  std::size_t wanted = 1;  // a hint of how many bytes come; 0 at the frame's end
  while (wanted != 0) {
    std::size_t taken = packed.size();
    std::size_t given = size - written;
    wanted = LZ4F_decompress(context.get(), bytes.data() + written, &given, packed.data(), &taken,
                             nullptr);
    if (LZ4F_isError(wanted) != 0U) return Damaged(Compression::kLz4, LZ4F_getErrorName(wanted));
    if (wanted != 0 && taken == 0 && given == 0) {
      return Damaged(Compression::kLz4, "it does not end where its header says");
    }
    written += given;
    packed.remove_prefix(taken);
  }
  if (written != size) return Damaged(Compression::kLz4, "it is shorter than its header says");
  return bytes;
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
  switch (compression) {
    case Compression::kNone:
      if (packed.size() != size)
        return Damaged(compression, "it is not as long as its header says");
      return std::string(packed);
    case Compression::kBz2:
      return DecompressBz2(packed, size);
    case Compression::kLz4:
      return DecompressLz4(packed, size);
  }
  return absl::InvalidArgumentError("compression is none of Compression");
}

}  // namespace dcloc::rosbag
