#include "core/map/keyframe_accuracy.h"

#include <algorithm>
#include <cmath>

namespace dcloc {
namespace {

constexpr std::uint32_t kCodeBits = 9;
constexpr std::uint32_t kMaxCode = (1U << kCodeBits) - 1;
constexpr std::uint32_t kTunnelBit = 1U << 27;
constexpr std::uint32_t kAliasBit = 1U << 28;
constexpr std::uint32_t kLookedBit = 1U << 29;
constexpr std::uint32_t kUnusedBits = 3U << 30;
constexpr double kStep = 1.02;  // from one code to the next
constexpr double kLeast_m = 1e-3;
constexpr double kLeast_rad = 1e-4;

/// 1 to kMaxCode.
std::uint32_t CodeOf(double sigma, double least) {
  const double code = 1.0 + std::round(std::log(std::max(sigma, least) / least) / std::log(kStep));
  return static_cast<std::uint32_t>(std::min(code, static_cast<double>(kMaxCode)));
}

double SigmaOf(std::uint32_t code, double least) {
  return least * std::pow(kStep, static_cast<double>(code) - 1.0);
}

std::uint32_t Code(std::uint32_t word, std::uint32_t index) {
  return (word >> (index * kCodeBits)) & kMaxCode;
}

}  // namespace

std::uint32_t PackAccuracy(const KeyframeAccuracy& accuracy) {
  std::uint32_t word = kLookedBit;
  if (accuracy.sigmas) {
    word |= CodeOf(accuracy.sigmas->along_m, kLeast_m) |
            CodeOf(accuracy.sigmas->across_m, kLeast_m) << kCodeBits |
            CodeOf(accuracy.sigmas->heading_rad, kLeast_rad) << (2 * kCodeBits);
  }
  if (accuracy.is_tunnel) word |= kTunnelBit;
  if (accuracy.is_alias) word |= kAliasBit;
  return word;
}

std::optional<KeyframeAccuracy> UnpackAccuracy(std::uint32_t word) {
  if (word == 0) return std::nullopt;
  KeyframeAccuracy accuracy{.sigmas = std::nullopt,
                            .is_tunnel = (word & kTunnelBit) != 0,
                            .is_alias = (word & kAliasBit) != 0};
  if (Code(word, 0) != 0) {
    accuracy.sigmas = {.along_m = SigmaOf(Code(word, 0), kLeast_m),
                       .across_m = SigmaOf(Code(word, 1), kLeast_m),
                       .heading_rad = SigmaOf(Code(word, 2), kLeast_rad)};
  }
  return accuracy;
}

bool IsAccuracyWord(std::uint32_t word) {
  if (word == 0) return true;
  if ((word & kLookedBit) == 0 || (word & kUnusedBits) != 0) return false;
  const bool has_sigmas = Code(word, 0) != 0;
  return (Code(word, 1) != 0) == has_sigmas && (Code(word, 2) != 0) == has_sigmas;
}

}  // namespace dcloc
