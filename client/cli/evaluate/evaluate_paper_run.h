#pragma once

#include <string>

#include "absl/status/status.h"

namespace dcloc::cli {

/// What `dcloc evaluate paper` was asked for.
struct PaperArguments {
  std::string folder;
  std::string data;  ///< empty for simulated drives alone
  bool quick = false;
  bool keep_runs = false;  ///< reuse finished runs of any build and options
};

/// Does the runs of the study that are not finished, prints the summary and writes the report.
absl::Status RunPaper(const PaperArguments& arguments);

}  // namespace dcloc::cli
