#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "tests/fuzz/fuzz_target.h"

// Drives a fuzz target without libFuzzer:
//   TARGET [SECONDS]       mutates the seeds at random, always in the same order
//   TARGET FILE            runs one input, to look at a crash
//   TARGET --seeds FOLDER  writes the seeds, for libFuzzer to begin with

namespace {

using Input = std::vector<std::uint8_t>;

// Ends of integers, infinities and NaN, as they lie in aligned words of files and messages.
constexpr std::array<std::uint32_t, 8> kExtremes = {0,          1,          0x7FFFFFFF, 0x80000000,
                                                    0xFFFFFFFF, 0x7FF00000, 0x7FC00000, 0x7F800000};

void Mutate(Input& input, std::mt19937& random) {
  const auto below = [&](std::size_t bound) {
    return std::uniform_int_distribution<std::size_t>(0, bound - 1)(random);
  };
  for (std::size_t changes = below(4) + 1; changes > 0 && !input.empty(); --changes) {
    const std::size_t at = below(input.size());
    const auto position = input.begin() + static_cast<std::ptrdiff_t>(at);
    switch (below(5)) {
      case 0:  // flip a bit
        *position ^= static_cast<std::uint8_t>(1U << below(8));
        break;
      case 1:  // change a byte
        *position = static_cast<std::uint8_t>(below(256));
        break;
      case 2: {  // make a word extreme
        const std::uint32_t word = kExtremes[below(kExtremes.size())];
        const std::size_t begin = at / sizeof(word) * sizeof(word);
        if (begin + sizeof(word) <= input.size()) std::memcpy(&input[begin], &word, sizeof(word));
        break;
      }
      case 3:  // cut the end off
        input.resize(at);
        break;
      default:  // shift the rest by a byte
        input.insert(position, static_cast<std::uint8_t>(below(256)));
        break;
    }
  }
}

int RunFile(const char* path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    std::fprintf(stderr, "%s: cannot be read\n", path);
    return EXIT_FAILURE;
  }
  const Input input{std::istreambuf_iterator<char>(file), {}};
  return LLVMFuzzerTestOneInput(input.data(), input.size());
}

int WriteSeeds(const std::filesystem::path& folder) {
  int number = 0;
  for (const Input& seed : dcloc::FuzzSeeds()) {
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

}  // namespace

int main(int argc, char** argv) {
  if (argc == 3 && std::string_view(argv[1]) == "--seeds") return WriteSeeds(argv[2]);
  char* end = nullptr;
  const double seconds = argc > 1 ? std::strtod(argv[1], &end) : 5.0;
  if (argc > 1 && *end != '\0') return RunFile(argv[1]);
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  const std::vector<Input> seeds = dcloc::FuzzSeeds();
  std::mt19937 random(1);
  std::size_t runs = 0;
  for (const Input& seed : seeds) LLVMFuzzerTestOneInput(seed.data(), seed.size());
  while (std::chrono::steady_clock::now() < deadline) {
    Input input = seeds[runs++ % seeds.size()];
    Mutate(input, random);
    LLVMFuzzerTestOneInput(input.data(), input.size());
  }
  std::printf("%zu inputs, no crash\n", runs);
  return EXIT_SUCCESS;
}
