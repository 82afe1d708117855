#include "server/base/sha256.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace dcloc::server {
namespace {

std::span<const std::byte> BytesOf(absl::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

// The examples of FIPS 180-2.
constexpr const char* kOfNothing =
    "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
constexpr const char* kOfAbc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";

TEST(Sha256Test, PartsGiveTheHashOfTheWhole) {
  EXPECT_EQ(Sha256().Finish(), kOfNothing);
  Sha256 hash;
  hash.Update(BytesOf("a"));
  hash.Update({});
  Sha256 moved = std::move(hash);
  moved.Update(BytesOf("bc"));
  EXPECT_EQ(moved.Finish(), kOfAbc);
}

TEST(Sha256Test, OnlyLowerCaseDigitsOfTheRightNumberAreAHash) {
  EXPECT_TRUE(IsSha256(kOfAbc));
  const std::string abc(kOfAbc);
  for (const std::string& text :
       {std::string(), abc.substr(1), absl::StrCat(abc, "0"), absl::StrCat("B", abc.substr(1)),
        absl::StrCat("g", abc.substr(1)), absl::StrCat("/", abc.substr(1))}) {
    EXPECT_FALSE(IsSha256(text)) << text;
  }
}

}  // namespace
}  // namespace dcloc::server
