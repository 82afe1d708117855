#include "client/cli/dataset/inspect_run.h"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/common/atomic_file.h"
#include "client/cli/common/terminal.h"
#include "client/cli/dataset/inspect_text.h"
#include "client/datasets/bag_overview.h"
#include "client/datasets/check/mapping_correction.h"
#include "client/datasets/check/range_rate_check.h"
#include "client/datasets/check/scan_statistics.h"
#include "client/datasets/rosbag.h"

namespace dcloc::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

std::string NameOf(DatasetFormat format) {
  for (const auto& [name, known] : kDatasetFormatNames) {
    if (known == format) return name;
  }
  return "";
}

/// Whether the drives of a format are bags, which have a mapping.
bool IsOfBags(const std::string& name) {
  const absl::StatusOr<DatasetFormat> format = DatasetFormatByName(name);
  return format.ok() && (*format == DatasetFormat::kRosbag || BagSetOf(*format).has_value());
}

/// Puts what `path` means into the other arguments, and finds the format.
absl::Status Resolve(InspectArguments& arguments) {
  std::error_code error;
  if (!arguments.path.empty() && fs::is_directory(arguments.path, error)) {
    arguments.dataset.root = arguments.path;
  } else if (!arguments.path.empty()) {
    const fs::path bag = arguments.path;
    if (bag.extension() != ".bag") {
      // What else it is, the reader of bags knows best.
      const absl::Status status = ReadBagOverview(bag).status();
      return status.ok() ? absl::InvalidArgumentError(
                               absl::StrCat(bag.string(), ": is a bag; let its name end with .bag"))
                         : status;
    }
    arguments.dataset.format = NameOf(DatasetFormat::kRosbag);
    arguments.dataset.root = bag.has_parent_path() ? bag.parent_path().string() : ".";
    arguments.drive.name = bag.filename().string();
  }
  if (!arguments.dataset.format.empty()) return absl::OkStatus();
  const absl::StatusOr<DatasetFormat> format = DetectFormat(arguments.dataset.root);
  if (format.ok()) arguments.dataset.format = NameOf(*format);
  return format.status();
}

/// Says step by step what there is; for scripts all of it at the end, whatever failed.
class Inspection {
 public:
  explicit Inspection(const InspectArguments& arguments) : arguments_(arguments) {}

  absl::Status Run() {
    absl::Status status = arguments_.drive.name.empty() ? InspectFolder() : InspectDrive();
    if (!arguments_.json) return status;
    if (!status.ok()) json_["error"] = status.message();
    absl::PrintF("%s\n", json_.dump(2, ' ', false, ordered_json::error_handler_t::replace));
    return status;
  }

 private:
  void Say(const std::string& text) const {
    if (!arguments_.json) absl::PrintF("%s", text);
  }

  absl::Status InspectFolder() {
    const absl::StatusOr<DatasetFormat> format = DatasetFormatByName(arguments_.dataset.format);
    if (!format.ok()) return format.status();
    const auto names = DriveNames({*format, arguments_.dataset.root, arguments_.dataset.version});
    if (!names.ok()) return names.status();
    json_["dataset"] = arguments_.dataset.format;
    json_["drives"] = *names;
    if (names->size() == 1) {
      arguments_.drive.name = names->front();
      return InspectDrive();
    }
    std::string text =
        absl::StrFormat("%s: %d drives of the format %s; --drive NAME tells more:\n",
                        Visible(arguments_.dataset.root), names->size(), arguments_.dataset.format);
    for (const std::string& name : *names) absl::StrAppend(&text, "  ", Visible(name), "\n");
    Say(text);
    return absl::OkStatus();
  }

  absl::Status InspectDrive() {
    std::optional<BagMapping> mapping;
    if (IsOfBags(arguments_.dataset.format)) {
      if (absl::Status status = InspectBag(mapping); !status.ok()) return status;
    }
    const absl::StatusOr<Drive> drive = ReadDrive(arguments_.dataset, arguments_.drive);
    if (!drive.ok()) {
      // Its mapping may be what is wrong: it is shown, to be changed.
      if (mapping) Say(MappingText(*mapping));
      return drive.status();
    }
    const std::vector<RangeRateCheck> checks = CheckRangeRates(*drive);
    const std::vector<ScanStatistics> statistics = ScanStatisticsOf(*drive);
    json_["drive"] = DriveJson(*drive, statistics, checks);
    Say(DriveText(*drive, statistics, checks));
    return mapping ? TellMapping(*mapping, checks) : absl::OkStatus();
  }

  absl::Status InspectBag(std::optional<BagMapping>& mapping) {
    const fs::path root = arguments_.dataset.root;
    const auto set = BagSetOf(*DatasetFormatByName(arguments_.dataset.format));
    const auto bag =
        set ? FindBagOfSet(root, arguments_.drive.name) : FindBag(root, arguments_.drive.name);
    if (!bag.ok()) return bag.status();
    const absl::StatusOr<BagOverview> overview = ReadBagOverview(*bag);
    if (!overview.ok()) return overview.status();
    json_["bag"] = OverviewJson(*overview);
    Say(OverviewText(bag->string(), *overview));
    absl::StatusOr<BagMapping> found = set ? MappingOfSet(*set, root, *bag) : MappingFor(*bag);
    if (!found.ok()) return found.status();
    json_["mapping"] = BagMappingJson(*found);
    mapping = *std::move(found);
    return absl::OkStatus();
  }

  /// What the data suggest, and where that is not what is in use.
  absl::Status TellMapping(const BagMapping& in_use, const std::vector<RangeRateCheck>& checks) {
    const BagMapping mapping = CorrectedMapping(in_use, checks);
    const ordered_json proposed = BagMappingJson(mapping);
    const bool is_changed = proposed != BagMappingJson(in_use);
    json_["proposed_mapping"] = proposed;
    json_["mapping_is_sound"] = !is_changed;
    if (arguments_.mapping_file.empty()) {
      Say(is_changed ? "The mapping in use does not fit the data; this one does, as dcloc_bag.json "
                       "beside the bag:\n"
                     : "It is read by this mapping, which dcloc_bag.json beside the bag may "
                       "change:\n");
      Say(MappingText(mapping));
      return absl::OkStatus();
    }
    const std::string text = proposed.dump(2) + "\n";
    if (is_changed) Say("The mapping in use does not fit the data; the one written does.\n");
    return WriteFileAtomically(arguments_.mapping_file, std::as_bytes(std::span(text)));
  }

  InspectArguments arguments_;
  ordered_json json_;
};

}  // namespace

absl::Status RunInspect(InspectArguments arguments) {
  if (absl::Status status = Resolve(arguments); !status.ok()) return status;
  if (!IsOfBags(arguments.dataset.format) && !arguments.mapping_file.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--write-mapping: only bags have a mapping; this is ", arguments.dataset.format));
  }
  return Inspection(arguments).Run();
}

}  // namespace dcloc::cli
