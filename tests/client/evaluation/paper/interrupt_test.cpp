#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/client/cli/fixtures/dcloc_process.h"
#include "tests/client/datasets/temp_folder.h"

namespace dcloc {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> RunFiles(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder / "runs", error)) {
    if (entry.path().extension() == ".json") files.push_back(entry.path());
  }
  return files;
}

TEST(EvaluatePaper, LeavesOnlyWholeFilesWhenItIsInterrupted) {
  if (std::system("command -v gnuplot >/dev/null") != 0) GTEST_SKIP() << "gnuplot is missing";
  const TempFolder folder;
  const fs::path out = folder.path() / "paper";
  DclocProcess process("evaluate paper --quick --out " + out.string());
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::minutes(6);
  while (RunFiles(out).size() < 2 && !process.HasEnded() &&
         std::chrono::steady_clock::now() < give_up) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  process.Signal(SIGINT);
  EXPECT_NE(process.Wait().exit_code, 0);
  const auto files = RunFiles(out);
  EXPECT_GE(files.size(), 2U);
  for (const fs::path& path : files) {
    std::ifstream file(path);
    const auto json = nlohmann::json::parse(file, nullptr, false);
    EXPECT_TRUE(json.is_object()) << path;
  }
  EXPECT_FALSE(fs::exists(out / "report.html"));
}

}  // namespace
}  // namespace dcloc
