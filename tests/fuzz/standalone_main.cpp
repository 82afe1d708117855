#include <sys/mman.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/mutate.h"

// Drives a fuzz target without libFuzzer. Inputs are tried in a child process, so that the one that
// ends it can be kept.

namespace {

using dcloc::FuzzInput;

constexpr char kUsage[] =
    "Usage: TARGET [SECONDS]            mutates the seeds at random, always in the same order\n"
    "       TARGET --inputs N [SEED]    the same for N inputs, in another order for another SEED\n"
    "       TARGET FILE                 runs one input, to look at a crash\n"
    "       TARGET --seeds FOLDER       writes the seeds, for libFuzzer to begin with\n"
    "An input that crashes, takes more than 30 s of a processor or ten minutes in all, is kept in\n"
    "the file TARGET.crash.\n";

constexpr std::size_t kMaxKeptBytes = std::size_t{4} << 20;
constexpr itimerval kLoops{.it_interval = {}, .it_value = {.tv_sec = 30}};
constexpr unsigned kHangs_s = 600;

/// What both processes see.
struct Shared {
  std::size_t run_count;
  std::size_t input_size;
  std::uint8_t input[kMaxKeptBytes];
};

/// How much is tried.
struct Extent {
  double seconds = std::numeric_limits<double>::infinity();
  std::size_t input_count = std::numeric_limits<std::size_t>::max();
  unsigned seed = 1;
};

int RunFile(const char* path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    std::fprintf(stderr, "%s: cannot be read\n%s", path, kUsage);
    return EXIT_FAILURE;
  }
  const FuzzInput input{std::istreambuf_iterator<char>(file), {}};
  return LLVMFuzzerTestOneInput(input.data(), input.size());
}

int WriteSeeds(const std::filesystem::path& folder) {
  int number = 0;
  for (const FuzzInput& seed : dcloc::FuzzSeeds()) {
    std::ofstream file(folder / std::to_string(number++), std::ios::binary);
    file.write(reinterpret_cast<const char*>(seed.data()),
               static_cast<std::streamsize>(seed.size()));
    if (!file.flush()) {
      std::fprintf(stderr, "%s: cannot be written to\n", folder.c_str());
      return EXIT_FAILURE;
    }
  }
  return EXIT_SUCCESS;
}

void Try(const FuzzInput& input, Shared& shared) {
  shared.input_size = std::min(input.size(), kMaxKeptBytes);
  std::memcpy(shared.input, input.data(), shared.input_size);
  setitimer(ITIMER_PROF, &kLoops, nullptr);  // others may have the processor meanwhile
  alarm(kHangs_s);
  LLVMFuzzerTestOneInput(input.data(), input.size());
  ++shared.run_count;
}

void TryMany(const Extent& extent, Shared& shared) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  const std::vector<FuzzInput> seeds = dcloc::FuzzSeeds();
  std::mt19937 random(extent.seed);
  for (const FuzzInput& seed : seeds) Try(seed, shared);
  for (std::size_t i = 0; i < extent.input_count; ++i) {
    if (std::chrono::duration<double>(Clock::now() - begin).count() > extent.seconds) break;
    FuzzInput input = seeds[i % seeds.size()];
    dcloc::Mutate(input, seeds, random);
    Try(input, shared);
  }
}

int KeepCrash(const char* program, int status, const Shared& shared) {
  const std::string path = std::filesystem::path(program).filename().string() + ".crash";
  std::ofstream(path, std::ios::binary | std::ios::trunc)
      .write(reinterpret_cast<const char*>(shared.input),
             static_cast<std::streamsize>(shared.input_size));
  const char* how = WIFSIGNALED(status) ? strsignal(WTERMSIG(status)) : "it ended itself";
  std::fprintf(stderr, "input %zu of %zu bytes: %s; it is kept in %s\n", shared.run_count,
               shared.input_size, how, path.c_str());
  return EXIT_FAILURE;
}

int Drive(const char* program, const Extent& extent) {
  void* memory =
      mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::runtime_error("no memory to share");
  auto& shared = *static_cast<Shared*>(memory);
  const pid_t child = fork();
  if (child == 0) {
    TryMany(extent, shared);
    std::fflush(nullptr);
    std::_Exit(EXIT_SUCCESS);
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) != child) throw std::runtime_error("no process");
  if (status != 0) return KeepCrash(program, status, shared);
  std::printf("%zu inputs, no crash\n", shared.run_count);
  return EXIT_SUCCESS;
}

std::optional<double> NumberOf(const char* text) {
  char* end = nullptr;
  const double number = std::strtod(text, &end);
  if (*end != '\0' || !(number >= 0.0)) return std::nullopt;
  return number;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string_view> arguments(argv + 1, argv + argc);
  if (arguments.empty()) return Drive(argv[0], {.seconds = 5.0});
  if (arguments[0] == "--seeds" && arguments.size() == 2) return WriteSeeds(argv[2]);
  if (arguments[0] == "--inputs" && arguments.size() >= 2 && arguments.size() <= 3) {
    const auto count = NumberOf(argv[2]);
    const auto seed = arguments.size() == 3 ? NumberOf(argv[3]) : 1.0;
    if (count && seed) {
      return Drive(argv[0], {.input_count = static_cast<std::size_t>(*count),
                             .seed = static_cast<unsigned>(*seed)});
    }
  } else if (arguments.size() == 1) {
    const auto seconds = NumberOf(argv[1]);
    return seconds ? Drive(argv[0], {.seconds = *seconds}) : RunFile(argv[1]);
  }
  std::fputs(kUsage, stderr);
  return EXIT_FAILURE;
}
