// The program `dcloc` as a user meets it: what it prints, what it writes, what it returns.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "tests/client/cli/fixtures/dcloc_process.h"
#include "tests/client/datasets/temp_folder.h"
#include "tests/client/datasets/tiny_nuscenes.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(CommandLine, HelpsWithAnExampleForEachCommand) {
  for (const char* command : {"simulate", "map build", "map inspect", "evaluate"}) {
    const Result result = Dcloc(std::string(command) + " --help");
    EXPECT_EQ(result.exit_code, 0) << command;
    EXPECT_THAT(result.out, HasSubstr("Example")) << command;
    EXPECT_THAT(result.out, HasSubstr(std::string("dcloc ") + command)) << command;
  }
  EXPECT_EQ(Dcloc("--help").exit_code, 0);
}

/// All commands that can be run, by the program's own help.
std::vector<std::string> Commands(const std::string& path = "") {
  std::vector<std::string> commands;
  std::istringstream help(Dcloc(path + " --help").out);
  bool has_any = false;
  bool listed = false;  // up to the next empty line
  for (std::string line; std::getline(help, line);) {
    listed = (listed && !line.empty()) || line == "Subcommands:";
    has_any = has_any || listed;
    if (!listed || line.rfind("  ", 0) != 0 || line[2] == ' ') continue;
    const std::string name = line.substr(2, line.find(' ', 2) - 2);
    const std::vector<std::string> below = Commands(absl::StrCat(path, " ", name));
    commands.insert(commands.end(), below.begin(), below.end());
  }
  if (!has_any) commands.push_back(path.substr(1));
  return commands;
}

TEST(CommandLine, EveryCommandHasAnExample) {
  const std::vector<std::string> commands = Commands();
  EXPECT_GT(commands.size(), 15U);
  for (const std::string& command : commands) {
    const Result result = Dcloc(command + " --help");
    EXPECT_EQ(result.exit_code, 0) << command;
    EXPECT_THAT(result.out, HasSubstr("Example")) << command;
    EXPECT_THAT(result.out, HasSubstr("dcloc " + command)) << command;
  }
}

/// What bash offers for the word behind "dcloc WORDS".
std::string Offered(const std::string& words) {
  const std::string script =
      "bash -c '. <(" + std::string(DCLOC_PROGRAM) + " completion); COMP_WORDS=(dcloc " + words +
      " \"\"); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _dcloc; echo \"${COMPREPLY[*]}\"'";
  FILE* pipe = popen(script.c_str(), "r");  // NOLINT(cert-env33-c): the words are this test's own
  std::array<char, 8192> buffer{};
  const std::size_t size = fread(buffer.data(), 1, buffer.size(), pipe);
  pclose(pipe);
  return {buffer.data(), size};
}

TEST(CommandLine, CompletesWhatThereIs) {
  EXPECT_THAT(Offered(""),
              ::testing::AllOf(HasSubstr("map"), HasSubstr("session"), HasSubstr("--version")));
  EXPECT_THAT(Offered("session"), ::testing::AllOf(HasSubstr("watch"), HasSubstr("replay"),
                                                   ::testing::Not(HasSubstr("upload"))));
  EXPECT_THAT(Offered("session list"), HasSubstr("--token-file"));
  EXPECT_THAT(Offered("map delete --map x"), HasSubstr("--all-versions"))
      << "options of groups are there as well";
}

TEST(CommandLine, TheManualHasEveryCommandAndOption) {
  const std::string manual = Dcloc("manual").out;
  for (const std::string& command : Commands()) {
    const std::string escaped = absl::StrReplaceAll(command, {{"-", "\\-"}});
    EXPECT_THAT(manual, HasSubstr(".SS dcloc " + escaped + "\n")) << command;
  }
  for (const char* text :
       {"\\-\\-token\\-file", "\\-\\-all\\-versions", "DCLOC_TOKEN_FILE", ".TH DCLOC 1"}) {
    EXPECT_THAT(manual, HasSubstr(text));
  }
}

TEST(CommandLine, WhatAsksAServerAnswersScriptsToo) {
  int count = 0;
  for (const std::string& command : Commands()) {
    const std::string help = Dcloc(command + " --help").out;
    if (!absl::StrContains(help, "--token-file")) continue;
    EXPECT_THAT(help, HasSubstr("--json")) << command;
    ++count;
  }
  EXPECT_GT(count, 15);
}

TEST(CommandLine, SaysItsVersion) {
  const Result result = Dcloc("--version");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out,
              ::testing::MatchesRegex("dcloc [0-9]+\\.[0-9]+\\.[0-9]+\nbuild [0-9a-f]+, .+\n"));
}

TEST(CommandLine, ReturnsTwoForWhatMakesNoSense) {
  for (const char* arguments :
       {"", "fly", "map", "map build", "map inspect", "evaluate --dataset kitti",
        "map build --dataset nuscenes --root /nonexistent --drive a --out b", "--no-such-option"}) {
    const Result result = Dcloc(arguments);
    EXPECT_EQ(result.exit_code, 2) << arguments;
    EXPECT_FALSE(result.err.empty()) << arguments;
    EXPECT_THAT(result.out, IsEmpty()) << arguments;
  }
}

TEST(CommandLine, ReturnsOneForWhatFails) {
  const TempFolder folder;
  TinyNuScenes().WriteTo(folder);
  const std::string root = folder.path().string();
  const Result no_scene =
      Dcloc("map build --dataset nuscenes --root " + root + " --drive scene-7 --out /dev/null");
  EXPECT_EQ(no_scene.exit_code, 1);
  EXPECT_THAT(no_scene.err, HasSubstr("there is no scene \"scene-7\""));
  const Result no_map = Dcloc("map inspect " + root + "/none.dclm");
  EXPECT_EQ(no_map.exit_code, 1);
  EXPECT_THAT(no_map.err, HasSubstr("none.dclm"));
  const Result no_beta = Dcloc("map build --dataset nuscenes --root " + root +
                               " --drive scene-0001 --beta-s 1e9 --out " + root + "/map");
  EXPECT_EQ(no_beta.exit_code, 1);
  EXPECT_THAT(no_beta.err, HasSubstr("beta_s"));
}

}  // namespace
}  // namespace dcloc
