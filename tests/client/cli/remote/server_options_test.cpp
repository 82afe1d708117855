#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "server/app/storage.h"
#include "tests/client/cli/fixtures/server_commands.h"

// What all commands take that talk to a server.
namespace dcloc {
namespace {

using ::testing::HasSubstr;

using ServerOptionsTest = ServerCommands;

TEST_F(ServerOptionsTest, TheTokenIsGivenByFlagOrEnvironment) {
  const auto identities = *server::OpenIdentities(folder_.path() / "data");
  std::ofstream(File("token")) << *identities->Create(server::Proof::kToken, {.name = "ops"}, {})
                               << "\n";
  Result result = Dcloc(At("map list"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("Bearer"));
  EXPECT_EQ(Dcloc(At("map list") + "--token-file " + File("token")).exit_code, 0);
  setenv("DCLOC_TOKEN_FILE", File("token").c_str(), 1);
  result = Dcloc(At("map list"));
  unsetenv("DCLOC_TOKEN_FILE");
  EXPECT_EQ(result.exit_code, 0) << result.err;
}

TEST(ServerOptionsErrorTest, WithoutAServerTheErrorNamesIt) {
  for (const char* command : {"session list", "session show x", "server status", "server drain"}) {
    const Result result = Dcloc(std::string(command) + " --server 127.0.0.1:1");
    EXPECT_EQ(result.exit_code, 1) << command;
    EXPECT_THAT(result.err, HasSubstr("127.0.0.1:1")) << command;
  }
}

}  // namespace
}  // namespace dcloc
