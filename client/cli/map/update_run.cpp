#include "client/cli/map/update_run.h"

#include <algorithm>
#include <set>
#include <span>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "client/cli/common/atomic_file.h"
#include "client/cli/common/output_file.h"
#include "client/cli/common/stage_line.h"
#include "client/cli/common/stop_signals.h"
#include "client/cli/map/dataset_drives.h"
#include "client/cli/map/map_files.h"
#include "client/cli/map/update_report.h"

namespace dcloc::cli {
namespace {

/// One command's work.
class UpdateRun {
 public:
  explicit UpdateRun(const UpdateArguments& arguments) : arguments_(arguments) {}

  absl::Status Run() {
    absl::Status status = Check();
    if (!status.ok()) return status;
    auto base = ReadMapParts(arguments_.base);
    if (!base.ok()) return base.status();
    DatasetDrives drives(arguments_.dataset, arguments_.request, arguments_.drives);
    auto judged = BuildUpdate(*base, {.source = drives, .vehicles = {}, .held_out = HeldOut()},
                              arguments_.options, [this](const std::string& stage, double share) {
                                line_.Update(stage, share);
                                return true;
                              });
    if (!judged.ok()) return judged.status();
    report_ = {.base = arguments_.base, .judged = *std::move(judged), .out = ""};
    return WriteAll();
  }

 private:
  absl::Status Check() const {
    if (HeldOut() == arguments_.drives.size()) {
      return absl::InvalidArgumentError(
          absl::StrCat("--keep-out is ", arguments_.held_out, "; it must be one of --drive"));
    }
    if (arguments_.drives.size() < 3) {
      return absl::InvalidArgumentError(
          "an update needs three drives at least: two that agree, and one that is kept out");
    }
    std::set<std::string> names;
    for (const std::string& name : arguments_.drives) {
      if (names.insert(name).second) continue;
      return absl::InvalidArgumentError(absl::StrCat("--drive names ", name, " twice"));
    }
    if (arguments_.out == arguments_.report) {
      return absl::InvalidArgumentError(
          absl::StrCat("--out and --report are both ", arguments_.out));
    }
    absl::Status status = CheckOutputFiles({{arguments_.out, arguments_.report}, arguments_.force});
    status.Update(CheckFolders({arguments_.out, arguments_.report}));
    return status;
  }

  /// Its number among the drives; theirs where it is none.
  std::size_t HeldOut() const {
    if (arguments_.held_out.empty()) return arguments_.drives.size() - 1;
    return static_cast<std::size_t>(std::ranges::find(arguments_.drives, arguments_.held_out) -
                                    arguments_.drives.begin());
  }

  std::string Description() const {
    std::vector<std::string> names;
    for (const std::size_t i : report_.judged.update.order) {
      names.push_back(report_.judged.passes[i].name);
    }
    return absl::StrCat("dcloc map update: ", arguments_.dataset.format, " ",
                        absl::StrJoin(names, ", "), "; ", DescribeJudgement(report_.judged));
  }

  absl::Status WriteAll() {
    const StopSignals stop;  // not between a file and its page
    absl::Status status;
    if (report_.judged.gate.is_better) {
      EditableMap& map = report_.judged.update.map;
      map.description = Description();
      const auto info = WriteMapParts(map, arguments_.out);
      status = info.status();
      if (status.ok()) report_.out = arguments_.out;
    } else {
      status = absl::FailedPreconditionError(
          absl::StrCat(arguments_.out, " is not written: ", report_.judged.gate.reason));
    }
    if (!arguments_.report.empty()) {
      const std::string page = UpdateHtml(report_);
      status.Update(WriteFileAtomically(arguments_.report, std::as_bytes(std::span(page))));
    }
    absl::PrintF("%s", arguments_.json ? UpdateJson(report_).dump(2) + "\n" : UpdateText(report_));
    return status;
  }

  const UpdateArguments& arguments_;
  StageLine line_;
  UpdateReport report_;
};

}  // namespace

absl::Status RunUpdate(const UpdateArguments& arguments) { return UpdateRun(arguments).Run(); }

}  // namespace dcloc::cli
