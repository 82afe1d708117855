#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace dcloc::robustness {

/// Rows of text, the first being the header.
using TextTable = std::vector<std::vector<std::string>>;

/// A cell: "-" for NaN, "never" for infinity.
std::string Fixed(double value, int digits);

/// `count` of `total` as a share, [0, 1]; NaN for a total of 0.
double Share(std::size_t count, std::size_t total);

/// The mean of `count` values of that `sum`; NaN for none.
double Mean(double sum, std::size_t count);

/// null where JSON has no such number.
nlohmann::ordered_json Number(double value);

/// Median, 99th percentile and maximum as of QuantileOf, as a cell.
std::string ThreeQuantiles(const std::vector<double>& values, std::size_t count);

}  // namespace dcloc::robustness
