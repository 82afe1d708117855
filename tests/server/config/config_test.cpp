#include "server/config/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <span>
#include <string>
#include <vector>

#include "server/config/command_line.h"
#include "tests/core/map/temporary_folder.h"

namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::filesystem::path WriteText(const TemporaryFolder& folder, const std::string& text) {
  return folder.Write("config.json", std::as_bytes(std::span(text)));
}

absl::StatusOr<CommandLine> Parse(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "dcloc-server");
  return ParseCommandLine(static_cast<int>(arguments.size()), arguments.data());
}

std::string ErrorOfFile(const std::string& text) {
  const TemporaryFolder folder;
  ServerConfig config;
  const absl::Status status = ReadConfigFile(WriteText(folder, text), &config);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << text;
  return std::string(status.message());
}

TEST(ConfigFileTest, TakesWhatItHasAndLeavesTheRest) {
  const TemporaryFolder folder;
  ServerConfig config;
  const absl::Status status = ReadConfigFile(
      WriteText(folder, R"({"data": "/srv/maps", "worker_count": 3, "stub_localizer": true})"),
      &config);
  ASSERT_TRUE(status.ok()) << status;
  EXPECT_EQ(config.data, "/srv/maps");
  EXPECT_EQ(config.worker_count, 3);
  EXPECT_TRUE(config.stub_localizer);
  EXPECT_EQ(config.listen, ServerConfig().listen);
}

TEST(ConfigFileTest, ErrorsNameFileKeyValueAndBound) {
  EXPECT_THAT(ErrorOfFile(R"({"worker_cout": 3})"),
              AllOf(HasSubstr("config.json"), HasSubstr("worker_cout"), HasSubstr("3"),
                    HasSubstr("unknown")));
  EXPECT_THAT(ErrorOfFile(R"({"worker_count": 3, "data": "a", "worker_count": 4})"),
              AllOf(HasSubstr("\"worker_count\""), HasSubstr("more than once")));
  EXPECT_THAT(ErrorOfFile(R"({"worker_count": -1})"),
              AllOf(HasSubstr("worker_count is -1"), HasSubstr("[0, 1024]")));
  EXPECT_THAT(ErrorOfFile(R"({"worker_count": 99999999999999999999})"), HasSubstr("worker_count"));
  EXPECT_THAT(ErrorOfFile(R"({"worker_count": 2.5})"), HasSubstr("worker_count is 2.5"));
  EXPECT_THAT(ErrorOfFile(R"({"worker_count": "2"})"), HasSubstr("an integer"));
  EXPECT_THAT(ErrorOfFile(R"({"stub_localizer": 1})"), HasSubstr("true or false"));
  EXPECT_THAT(ErrorOfFile(R"({"data": null})"), HasSubstr("data is null"));
  EXPECT_THAT(ErrorOfFile("[1]"), HasSubstr("an object"));
  EXPECT_THAT(ErrorOfFile("{\"data\": "), HasSubstr("config.json"));
  EXPECT_THAT(ErrorOfFile("{\"data\": \"\xff\"}"), HasSubstr("config.json"));
}

TEST(ConfigFileTest, AMissingFileIsNotFound) {
  ServerConfig config;
  EXPECT_EQ(ReadConfigFile("/nowhere/config.json", &config).code(), absl::StatusCode::kNotFound);
}

TEST(CommandLineTest, FlagsGoBeforeTheFileAndTheFileBeforeDefaults) {
  const TemporaryFolder folder;
  const std::string path =
      WriteText(folder, R"({"data": "/from/file", "worker_count": 3, "max_session_count": 5})");
  const absl::StatusOr<CommandLine> line =
      Parse({"--config", path.c_str(), "--worker-count", "7", "--stub-localizer"});
  ASSERT_TRUE(line.ok()) << line.status();
  EXPECT_FALSE(line->print.has_value());
  EXPECT_EQ(line->config.data, "/from/file");
  EXPECT_EQ(line->config.worker_count, 7);
  EXPECT_EQ(line->config.max_session_count, 5);
  EXPECT_TRUE(line->config.stub_localizer);
  EXPECT_EQ(line->config.max_map_mib, ServerConfig().max_map_mib);
}

TEST(CommandLineTest, ARenamedSettingIsKnownByItsFormerNameToo) {
  const TemporaryFolder folder;
  const std::string path = WriteText(folder, R"({"data": "d", "stub_matcher": true})");
  EXPECT_TRUE(Parse({"--config", path.c_str()})->config.stub_localizer);
  EXPECT_TRUE(Parse({"--data", "d", "--stub-matcher"})->config.stub_localizer);
  EXPECT_FALSE(Parse({"--data", "d"})->config.stub_localizer);
}

TEST(CommandLineTest, ChecksWithoutStarting) {
  EXPECT_TRUE(Parse({"--data", "d", "--check-config"})->check_config);
  EXPECT_FALSE(Parse({"--data", "d"})->check_config);
}

TEST(ConfigTest, ChangesAreFoundFieldByField) {
  ServerConfig before;
  ServerConfig after = before;
  EXPECT_TRUE(ChangedFields(before, after).empty());
  after.max_session_count = 7;
  after.listen = "127.0.0.1:1";
  after.stub_localizer = true;
  std::vector<std::string> keys;
  for (const ConfigField* field : ChangedFields(before, after)) {
    keys.emplace_back(field->key);
    TakeField(*field, after, &before);
  }
  EXPECT_THAT(keys, ::testing::ElementsAre("listen", "stub_localizer", "max_session_count"));
  EXPECT_TRUE(ChangedFields(before, after).empty());
}

TEST(ConfigTest, LimitsAndLogLevelChangeWhileRunningAddressesDoNot) {
  const auto reloadable = [](const std::string& key) {
    for (const ConfigField& field : ConfigFields()) {
      if (field.key == key) return field.reloadable;
    }
    ADD_FAILURE() << key;
    return false;
  };
  for (const char* key :
       {"max_session_count", "max_session_count_per_principal", "max_scan_rate_hz_per_principal",
        "max_target_count", "max_map_mib", "max_tenant_storage_mib", "log_level"}) {
    EXPECT_TRUE(reloadable(key)) << key;
  }
  for (const char* key : {"data", "listen", "tls_cert", "worker_count", "require_identity"}) {
    EXPECT_FALSE(reloadable(key)) << key;
  }
}

class SharedConfigTest : public ::testing::Test {
 protected:
  std::string Error() const {
    const absl::Status status = Validate(config_);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  }

  ServerConfig config_ = [] {
    ServerConfig config;
    config.data = "/srv/dcloc";
    config.catalogue = "postgresql://dcloc@/dcloc";
    config.map_files = "s3://maps/site";
    config.object_endpoint = "https://s3.example.org";
    return config;
  }();
};

TEST_F(SharedConfigTest, MapFilesAreInAFolderOrInAnObjectStore) {
  EXPECT_TRUE(Validate(config_).ok());
  config_.map_folder = "/srv/maps";
  EXPECT_THAT(Error(), AllOf(HasSubstr("map_folder is \"/srv/maps\""),
                             HasSubstr("map_files is \"s3://maps/site\"")));
  config_.map_folder = config_.map_files = config_.object_endpoint = "";
  EXPECT_THAT(Error(), AllOf(HasSubstr("catalogue is there"), HasSubstr("map_files is \"\"")));
  config_.map_files = "s3://maps/site";
  config_.object_endpoint = "https://s3.example.org";
  config_.catalogue = "";
  EXPECT_THAT(Error(), HasSubstr("catalogue is empty"));
}

TEST_F(SharedConfigTest, AnObjectStoreIsCheckedAtTheDoor) {
  config_.object_endpoint = "s3.example.org";
  EXPECT_THAT(Error(), HasSubstr("object_endpoint is \"s3.example.org\""));
  config_.object_endpoint = "https://s3.example.org";
  config_.max_map_mib = 5121;
  EXPECT_THAT(Error(), AllOf(HasSubstr("max_map_mib is 5121"), HasSubstr("5120")));
  config_.max_map_mib = 5120;
  config_.object_timeout_ms = 99;
  EXPECT_THAT(Error(), HasSubstr("object_timeout_ms is 99"));
  config_.object_timeout_ms = 100;
  config_.map_files = "";
  config_.map_folder = "/srv/maps";
  EXPECT_THAT(Error(), AllOf(HasSubstr("object_endpoint"), HasSubstr("map_files is empty")));
}

TEST(CommandLineTest, HelpShowsEverySettingAndExamples) {
  const absl::StatusOr<CommandLine> line = Parse({"--help"});
  ASSERT_TRUE(line.ok());
  ASSERT_TRUE(line->print.has_value());
  for (const char* flag : {"--data", "--listen", "--tls-client-ca", "--stub-localizer",
                           "--allow-plaintext-off-loopback", "--config", "Examples:"}) {
    EXPECT_THAT(*line->print, HasSubstr(flag));
  }
}

TEST(CommandLineTest, ErrorsSayWhatIsWrong) {
  EXPECT_THAT(std::string(Parse({}).status().message()), HasSubstr("data"));
  EXPECT_THAT(std::string(Parse({"--data", "d", "--no-such-flag"}).status().message()),
              HasSubstr("--no-such-flag"));
  EXPECT_THAT(std::string(Parse({"--data", "d", "--worker-count", "x"}).status().message()),
              HasSubstr("--worker-count"));
  EXPECT_THAT(std::string(Parse({"--data", "d", "--worker-count", "-2"}).status().message()),
              AllOf(HasSubstr("worker_count is -2"), HasSubstr("[0, 1024]")));
  EXPECT_THAT(std::string(Parse({"--data", "d", "--log-level", "loud"}).status().message()),
              AllOf(HasSubstr("log_level"), HasSubstr("loud")));
  EXPECT_THAT(std::string(Parse({"--data", "d", "--log-format", "xml"}).status().message()),
              AllOf(HasSubstr("log_format"), HasSubstr("xml")));
  EXPECT_THAT(std::string(Parse({"--data", "d", "--tls-cert", "c.pem"}).status().message()),
              AllOf(HasSubstr("tls_key"), HasSubstr("c.pem")));
  EXPECT_THAT(std::string(Parse({"--data", "d", "--tls-client-ca", "a.pem"}).status().message()),
              AllOf(HasSubstr("tls_client_ca"), HasSubstr("a.pem")));
}

}  // namespace
}  // namespace dcloc::server
