#include "core/localizer/recent_answers.h"

#include <algorithm>

namespace dcloc {
const Localization* RecentAnswers::Find(std::uint64_t fingerprint) const {
  const auto end = answers_.begin() + static_cast<std::ptrdiff_t>(std::min(count_, kCount));
  const auto found = std::find_if(answers_.begin(), end, [&](const Answered& answered) {
    return answered.fingerprint == fingerprint;
  });
  return found == end ? nullptr : &found->answer;
}

void RecentAnswers::Add(std::uint64_t fingerprint, const Localization& answer) {
  answers_[count_ % kCount] = {fingerprint, answer};
  ++count_;
}

}  // namespace dcloc
