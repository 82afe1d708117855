#include "tests/fuzz/mutate.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <limits>
#include <string_view>

namespace dcloc {
namespace {

// An input does not grow beyond this.
constexpr std::size_t kMaxBytes = std::size_t{1} << 20;

// Ends of integers, infinities and NaN, as they lie in words of files and messages.
constexpr std::array<std::uint32_t, 9> kWords = {
    0, 1, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 0x7FF00000, 0x7FC00000, 0x7F800000, 0xFF800000};

constexpr std::array<double, 9> kDoubles = {std::numeric_limits<double>::quiet_NaN(),
                                            std::numeric_limits<double>::infinity(),
                                            -std::numeric_limits<double>::infinity(),
                                            std::numeric_limits<double>::max(),
                                            std::numeric_limits<double>::denorm_min(),
                                            -0.0,
                                            9.3e18,
                                            1e-300,
                                            -1.0};

constexpr std::array<std::string_view, 14> kTexts = {
    "nan", "inf", "-inf",   "1e999", "-1",   "-0",  "9223372036854775807", "-9223372036854775808",
    "",    "1e5", "1e-320", "null",  "[[[[", "true"};

class Mutator {
 public:
  Mutator(FuzzInput& input, std::mt19937& random) : input_(input), random_(random) {}

  std::size_t Below(std::size_t bound) {
    return std::uniform_int_distribution<std::size_t>(0, bound - 1)(random_);
  }

  void Change(const std::vector<FuzzInput>& others) {
    const std::size_t at = Below(input_.size());
    switch (Below(9)) {
      case 0:
        input_[at] ^= static_cast<std::uint8_t>(1U << Below(8));
        break;
      case 1:
        input_[at] = static_cast<std::uint8_t>(Below(256));
        break;
      case 2:
        Overwrite(at / sizeof(std::uint32_t) * sizeof(std::uint32_t), kWords[Below(kWords.size())]);
        break;
      case 3:  // messages do not align their numbers
        Overwrite(at, kDoubles[Below(kDoubles.size())]);
        break;
      case 4:
        ReplaceNumber(at);
        break;
      case 5:
        input_.resize(at);
        break;
      case 6:
        input_.insert(At(at), static_cast<std::uint8_t>(Below(256)));
        break;
      case 7:
        Insert(at, input_);
        break;
      default:
        Insert(at, others[Below(others.size())]);
        break;
    }
  }

 private:
  FuzzInput::iterator At(std::size_t at) {
    return input_.begin() + static_cast<std::ptrdiff_t>(at);
  }

  template <typename Number>
  void Overwrite(std::size_t at, Number number) {
    if (at + sizeof(number) <= input_.size()) std::memcpy(&input_[at], &number, sizeof(number));
  }

  // The text of a number, the next one from `at` on, becomes an extreme one.
  void ReplaceNumber(std::size_t at) {
    const auto is_digit = [](std::uint8_t byte) { return std::isdigit(byte) != 0; };
    const auto begin = std::find_if(At(at), input_.end(), is_digit);
    const auto end = std::find_if_not(begin, input_.end(), is_digit);
    const std::string_view text = kTexts[Below(kTexts.size())];
    const auto place = input_.erase(begin, end);
    input_.insert(place, text.begin(), text.end());
  }

  // A piece of `source`; up to all of it.
  void Insert(std::size_t at, const FuzzInput& source) {
    if (source.empty() || input_.size() + source.size() > kMaxBytes) return;
    const std::size_t first = Below(source.size());
    const std::size_t count = Below(source.size() - first) + 1;
    const FuzzInput piece(source.begin() + static_cast<std::ptrdiff_t>(first),
                          source.begin() + static_cast<std::ptrdiff_t>(first + count));
    input_.insert(At(at), piece.begin(), piece.end());
  }

  FuzzInput& input_;
  std::mt19937& random_;
};

}  // namespace

void Mutate(FuzzInput& input, const std::vector<FuzzInput>& others, std::mt19937& random) {
  Mutator mutator(input, random);
  for (std::size_t changes = mutator.Below(4) + 1; changes > 0 && !input.empty(); --changes) {
    mutator.Change(others);
  }
}

}  // namespace dcloc
