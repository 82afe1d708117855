#include "client/sdk/sha256.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/client/datasets/temp_folder.h"

namespace dcloc::client {
namespace {

TEST(Sha256OfFileTest, IsThatOfTheWholeFile) {
  const TempFolder folder;
  EXPECT_EQ(Sha256OfFile(folder.Write("abc", "abc")).value_or(""),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  // Longer than what is read at a time; sha256sum says the same.
  EXPECT_EQ(Sha256OfFile(folder.Write("million", std::string(3'000'000, 'a'))).value_or(""),
            "2a152c894398719c0570f83fac34ac03a0f6e8e474b995c2403aa5434f7b9dd4");
}

TEST(Sha256OfFileTest, AFileThatIsNotThereIsNamed) {
  const TempFolder folder;
  const absl::Status status = Sha256OfFile(folder.path() / "town.dclm").status();
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(status.message()), ::testing::HasSubstr("town.dclm"));
}

}  // namespace
}  // namespace dcloc::client
