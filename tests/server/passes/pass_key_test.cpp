#include "server/passes/pass_key.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/message_of.h"

namespace dcloc::server {
namespace {

using std::filesystem::perms;
using ::testing::HasSubstr;
using ::testing::Not;

class PassKeyTest : public ::testing::Test {
 protected:
  std::filesystem::path Write(const std::string& text) const {
    std::filesystem::path path = folder_.path() / "key";
    std::ofstream(path) << text;
    std::filesystem::permissions(path, perms::owner_read | perms::owner_write);
    return path;
  }

  TemporaryFolder folder_;
};

TEST_F(PassKeyTest, OneThatIsMadeStaysAndIsItsOwnersAlone) {
  const std::filesystem::path path = folder_.path() / "pass.key";
  const std::string key = *ReadOrMakePassKey(path);
  EXPECT_EQ(key.size(), 32U);
  EXPECT_EQ(*ReadOrMakePassKey(path), key);
  EXPECT_EQ(*ReadPassKey(path), key);
  EXPECT_EQ(std::filesystem::status(path).permissions() & (perms::group_all | perms::others_all),
            perms::none);
  EXPECT_NE(*ReadOrMakePassKey(folder_.path() / "other.key"), key);
}

TEST_F(PassKeyTest, AKeyOfAFileIsTakenWithSpaceAroundIt) {
  EXPECT_EQ(*ReadPassKey(Write(std::string(64, '0') + "\n")), std::string(32, '\0'));
}

TEST_F(PassKeyTest, FaultsNameTheFileAndNotTheKey) {
  const std::string secret(63, 'a');
  const std::string message = MessageOf(ReadPassKey(Write(secret)).status());
  EXPECT_THAT(message, HasSubstr("pass_key: " + (folder_.path() / "key").string()));
  EXPECT_THAT(message, HasSubstr("64 hexadecimal digits"));
  EXPECT_THAT(message, Not(HasSubstr("aaaa")));
  EXPECT_FALSE(ReadPassKey(Write(std::string(64, 'g'))).ok());
  EXPECT_THAT(MessageOf(ReadPassKey(folder_.path() / "none").status()), HasSubstr("none"));
  const std::filesystem::path path = Write(std::string(64, 'a'));
  std::filesystem::permissions(path, perms::others_read, std::filesystem::perm_options::add);
  EXPECT_THAT(MessageOf(ReadPassKey(path).status()), HasSubstr("others may read"));
}

}  // namespace
}  // namespace dcloc::server
