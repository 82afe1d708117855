#include "client/rosbag/compression.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

namespace dcloc::rosbag {
namespace {

constexpr Compression kAll[] = {Compression::kNone, Compression::kBz2, Compression::kLz4};

std::string Repeated() {
  std::string bytes;
  for (int i = 0; i < 100'000; ++i) bytes += static_cast<char>(i % 7);
  return bytes;
}

TEST(CompressionTest, BytesComeBackHoweverTheyArePacked) {
  for (const std::string& bytes : {std::string(), std::string("a"), Repeated()}) {
    for (const Compression compression : kAll) {
      const auto packed = Compress(bytes, compression);
      ASSERT_TRUE(packed.ok()) << packed.status();
      const auto unpacked = Decompress(*packed, compression, bytes.size());
      ASSERT_TRUE(unpacked.ok()) << NameOf(compression) << ": " << unpacked.status();
      EXPECT_EQ(*unpacked, bytes) << NameOf(compression);
      EXPECT_EQ(packed->size() < bytes.size() / 10,
                compression != Compression::kNone && bytes.size() > 1);
    }
  }
}

TEST(CompressionTest, DamageAndAWrongSizeAreNamed) {
  const std::string bytes = Repeated();
  for (const Compression compression : kAll) {
    const std::string packed = *Compress(bytes, compression);
    std::string damaged = packed;
    damaged[packed.size() / 2] = static_cast<char>(~damaged[packed.size() / 2]);
    for (const std::size_t size : {bytes.size() - 1, bytes.size() + 1, std::size_t{0}}) {
      EXPECT_EQ(Decompress(packed, compression, size).status().code(), absl::StatusCode::kDataLoss)
          << NameOf(compression) << " as " << size;
    }
    EXPECT_EQ(
        Decompress(packed.substr(0, packed.size() - 4), compression, bytes.size()).status().code(),
        absl::StatusCode::kDataLoss)
        << NameOf(compression);
    EXPECT_EQ(Decompress(damaged, compression, bytes.size()).ok(),
              compression == Compression::kNone)  // which has no checksum
        << NameOf(compression);
  }
}

TEST(CompressionTest, OfWhatIsCutOffTheWholeBlocksComeBack) {
  std::string bytes;
  std::mt19937 random(1);
  for (int i = 0; i < 3'000'000; ++i) bytes += static_cast<char>(random());
  for (const Compression compression : kAll) {
    const std::string packed = *Compress(bytes, compression);
    const std::string cut =
        DecompressCut(packed.substr(0, packed.size() * 3 / 4), compression, bytes.size());
    EXPECT_EQ(cut, bytes.substr(0, cut.size())) << NameOf(compression);
    EXPECT_GT(cut.size(), bytes.size() / 3) << NameOf(compression);
    EXPECT_LT(cut.size(), bytes.size()) << NameOf(compression);
    EXPECT_EQ(DecompressCut(packed, compression, 1000), bytes.substr(0, 1000));
    EXPECT_EQ(DecompressCut("no such thing", compression, 1000).empty(),
              compression != Compression::kNone);
  }
}

TEST(CompressionTest, NamesAreThoseOfBags) {
  for (const Compression compression : kAll) {
    EXPECT_EQ(CompressionByName(NameOf(compression)).value_or(Compression::kNone), compression);
  }
  EXPECT_EQ(CompressionByName("zip").status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace dcloc::rosbag
