#include "client/evaluation/robustness/cells.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/evaluation/robustness/tally.h"

namespace dcloc::robustness {

std::string Fixed(double value, int digits) {
  if (std::isnan(value)) return "-";
  if (std::isinf(value)) return "never";
  return absl::StrFormat("%.*f", digits, value);
}

double Share(std::size_t count, std::size_t total) {
  return total == 0 ? std::nan("") : static_cast<double>(count) / static_cast<double>(total);
}

nlohmann::ordered_json Number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

std::string ThreeQuantiles(const std::vector<double>& values, std::size_t count) {
  return absl::StrCat(Fixed(QuantileOf(values, count, 0.5), 2), " / ",
                      Fixed(QuantileOf(values, count, 0.99), 2), " / ",
                      Fixed(QuantileOf(values, count, 1.0), 2));
}

double Mean(double sum, std::size_t count) {
  return count == 0 ? std::nan("") : sum / static_cast<double>(count);
}

}  // namespace dcloc::robustness
