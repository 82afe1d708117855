#include "server/objects/object_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <span>
#include <string>

#include "server/objects/object_credentials.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/message_of.h"

namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

ObjectOptions Good() {
  ObjectOptions options{.location = "s3://maps/site/one"};
  options.endpoint = "https://s3.example.org";
  return options;
}

std::string ErrorOf(const ObjectOptions& options) {
  const absl::Status status = Validate(options);
  EXPECT_TRUE(absl::IsInvalidArgument(status));
  return MessageOf(status);
}

TEST(ObjectOptionsTest, ALocationIsABucketAndAPrefix) {
  EXPECT_TRUE(Validate(Good()).ok());
  EXPECT_EQ(ParseObjectLocation("s3://maps/site/one")->prefix, "site/one/");
  EXPECT_EQ(ParseObjectLocation("s3://maps/site/one/")->prefix, "site/one/");
  EXPECT_EQ(ParseObjectLocation("s3://maps")->prefix, "");
  EXPECT_EQ(ParseObjectLocation("s3://maps/")->bucket, "maps");
  for (const std::string bad :
       {"", "maps", "http://maps", "s3://", "s3://ma", "s3://Maps/a", "s3://-maps", "s3://maps/a b",
        "s3://maps/a//b", "s3://maps/../b", "s3://maps/a?b", "s3://ma_ps"}) {
    ObjectOptions options = Good();
    options.location = bad;
    EXPECT_THAT(ErrorOf(options),
                AllOf(HasSubstr("map_files is \"" + bad + "\""), HasSubstr("s3://BUCKET/PREFIX")));
  }
}

TEST(ObjectOptionsTest, AnEndpointIsAHostWithTlsUnlessItIsThisOne) {
  for (const char* good : {"https://s3.example.org", "https://10.0.0.1:9000",
                           "http://127.0.0.1:9000", "http://localhost", "http://[::1]:9000"}) {
    ObjectOptions options = Good();
    options.endpoint = good;
    EXPECT_TRUE(Validate(options).ok()) << good;
  }
  for (const std::string bad :
       {"", "s3.example.org", "https://", "https://a/b", "https://a?b", "https://u@a",
        "https://a:0", "https://a:70000", "https://a:b", "ftp://a"}) {
    ObjectOptions options = Good();
    options.endpoint = bad;
    EXPECT_THAT(ErrorOf(options), HasSubstr("object_endpoint is \"" + bad + "\""));
  }
  ObjectOptions plain = Good();
  plain.endpoint = "http://s3.example.org";
  EXPECT_THAT(ErrorOf(plain), AllOf(HasSubstr("object_endpoint"), HasSubstr("https://")));
}

TEST(ObjectOptionsTest, RegionAndTimeAreBounded) {
  ObjectOptions options = Good();
  options.region = "eu west";
  EXPECT_THAT(ErrorOf(options), HasSubstr("object_region is \"eu west\""));
  options = Good();
  options.timeout = std::chrono::milliseconds(0);
  EXPECT_THAT(ErrorOf(options), HasSubstr("object_timeout_ms is 0"));
}

class ObjectCredentialsTest : public ::testing::Test {
 protected:
  absl::StatusOr<ObjectCredentials> Read(
      const std::string& text, std::filesystem::perms mode = std::filesystem::perms::owner_read) {
    std::filesystem::remove(folder_.path() / "keys");
    const auto path = folder_.Write("keys", std::as_bytes(std::span(text)));
    std::filesystem::permissions(path, mode);
    return ReadObjectCredentials(path);
  }

  TemporaryFolder folder_;
};

TEST_F(ObjectCredentialsTest, AreReadAsOtherToolsReadThem) {
  const auto read = Read(
      "# of the fleet\n[default]\naws_access_key_id = KEY\naws_secret_access_key=a/b+c=\n"
      "[other]\naws_access_key_id = OTHER\n");
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->access_key_id, "KEY");
  EXPECT_EQ(read->secret_access_key, "a/b+c=");
  EXPECT_EQ(read->session_token, "");
  EXPECT_EQ(
      Read("aws_access_key_id=K\naws_secret_access_key=S\naws_session_token=T\n")->session_token,
      "T");
}

TEST_F(ObjectCredentialsTest, ErrorsNameWhatIsMissingAndNoSecret) {
  EXPECT_THAT(MessageOf(Read("aws_access_key_id = KEY\n").status()),
              AllOf(HasSubstr("object_credentials"), HasSubstr("keys"),
                    HasSubstr("aws_secret_access_key is missing")));
  const absl::Status odd =
      Read("aws_access_key_id = KEY\naws_secret_access_key = se cret\n").status();
  EXPECT_THAT(MessageOf(odd), AllOf(HasSubstr("aws_secret_access_key"), Not(HasSubstr("cret\""))));
  EXPECT_THAT(MessageOf(ReadObjectCredentials(folder_.path() / "none").status()),
              HasSubstr("object_credentials"));
  const auto everyone = std::filesystem::perms::owner_read | std::filesystem::perms::others_read;
  EXPECT_THAT(MessageOf(Read("aws_access_key_id=K\naws_secret_access_key=S\n", everyone).status()),
              HasSubstr("everyone"));
}

}  // namespace
}  // namespace dcloc::server
