#pragma once

#include <string>

#include "absl/status/status.h"

namespace dcloc::cli {

/// What `dcloc evaluate paper` was asked for.
struct PaperArguments {
  std::string folder;
  std::string data;  ///< empty for simulated drives alone
  bool quick = false;
  bool keep_runs = false;  ///< finished runs are taken, whatever did them
};

/// Does what of the study is not done yet, prints the summary and writes the report.
absl::Status RunPaper(const PaperArguments& arguments);

}  // namespace dcloc::cli
