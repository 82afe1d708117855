#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/localizer/localizer.h"

namespace dcloc {

/// The answers to the last scans: one that is sent twice is answered twice, and used once.
class RecentAnswers {
 public:
  /// The answer to the scan of this fingerprint (`FingerprintOf`), or null.
  const Localization* Find(std::uint64_t fingerprint) const;

  void Add(std::uint64_t fingerprint, const Localization& answer);

 private:
  static constexpr std::size_t kCount = 32;
  struct Answered {
    std::uint64_t fingerprint = 0;
    Localization answer;
  };
  std::array<Answered, kCount> answers_;
  std::size_t count_ = 0;  // ever added
};

}  // namespace dcloc
