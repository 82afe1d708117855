#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "client/evaluation/outcome.h"

namespace dcloc {

/// One way of localizing the drives.
struct ReportRun {
  std::string label;
  std::vector<DriveOutcome> outcomes;  ///< the same drives in the same order in every run
};

/// An evaluation to be shown.
struct Report {
  std::string title;
  std::vector<std::pair<std::string, std::string>> settings;  ///< name and value
  std::string note;                                           ///< a sentence; may be empty
  std::vector<ReportRun> runs;  ///< one or two; the first is drawn with its covariance
  bool is_track = true;         ///< answers follow one another, rather than being separate queries
};

/// Writes a self-contained HTML page with a summary and a picture of each drive, and each picture
/// as a PNG file beside it ("report.png", or "report-<drive>.png" where there are several drives).
absl::Status WriteReport(const Report& report, const std::filesystem::path& html);

}  // namespace dcloc
