#include "client/evaluation/faults/stanford_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "absl/strings/str_format.h"
#include "client/evaluation/plot_data.h"

namespace dcloc::faults {
namespace {

constexpr int kPicture_px = 800;

double LowerBound(int cell) {
  return std::pow(10.0, static_cast<double>(cell) / StanfordHistogram::kCellsPerDecade);
}

}  // namespace

Picture StanfordPicture(const StanfordHistogram& histogram) {
  std::vector<std::string> lines;
  int low = std::numeric_limits<int>::max(), high = std::numeric_limits<int>::min();
  for (const auto& [cell, count] : histogram.counts) {
    const auto [error, level] = cell;
    low = std::min({low, error, level});
    high = std::max({high, error, level});
    lines.push_back(absl::StrFormat("%.5g %.5g %.5g %.5g %.5g %.5g %d", LowerBound(error),
                                    LowerBound(level), LowerBound(error), LowerBound(error + 1),
                                    LowerBound(level), LowerBound(level + 1), count));
  }
  Picture picture{.width_px = kPicture_px, .height_px = kPicture_px};
  picture.commands = Block("cells", lines);
  absl::StrAppendFormat(&picture.commands,
                        "set logscale xy\nset logscale cb\nset size square\nunset key\n"
                        "set xrange [%.5g:%.5g]\nset yrange [%.5g:%.5g]\nset cbrange [1:*]\n"
                        "set xlabel 'position error [m]'\nset ylabel 'protection level [m]'\n"
                        "set cblabel 'answers'\nset palette defined (0 '#deebf7', 1 '#08306b')\n"
                        "set style fill solid noborder\n"
                        "plot $cells using 1:2:3:4:5:6:7 with boxxyerror linecolor palette, "
                        "x with lines linecolor rgb '#D55E00' linewidth 2\n",
                        LowerBound(low), LowerBound(high + 1), LowerBound(low),
                        LowerBound(high + 1));
  return picture;
}

}  // namespace dcloc::faults
