#include "client/simulation/nuscenes_writer.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <string_view>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/datasets/rig_file.h"
#include "client/simulation/change_description.h"
#include "client/simulation/nuscenes_tables_writer.h"
#include "client/simulation/radar_pcd_writer.h"

namespace dcloc {
namespace {

namespace fs = std::filesystem;

constexpr const char* kVersion = "v1.0-sim";

// A grey image of one pixel; the devkit opens the raster but nothing here needs it.
constexpr std::string_view kBlankPng(
    "\x89PNG\r\n\x1a\n"
    "\0\0\0\rIHDR\0\0\0\x01\0\0\0\x01\x08\0\0\0\0\x3a\x7e\x9b\x55"
    "\0\0\0\nIDAT\x78\xda\x63\x60\0\0\0\x02\0\x01\xe5\x27\xde\xfc"
    "\0\0\0\0IEND\xae\x42\x60\x82",
    67);

absl::Status FileFailure(const fs::path& path, std::string_view what,
                         const std::error_code& error) {
  return absl::UnavailableError(absl::StrCat(path.string(), ": ", std::string(what),
                                             error ? ": " + error.message() : std::string()));
}

absl::Status WriteFile(const fs::path& path, std::string_view bytes) {
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  if (error) return FileFailure(path.parent_path(), "cannot make the folder", error);
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  return file ? absl::OkStatus() : FileFailure(path, "cannot write", {});
}

absl::Status WriteJson(const fs::path& path, const nlohmann::ordered_json& json) {
  // Replacing what is not UTF-8 is what keeps dump() from throwing.
  return WriteFile(path, json.dump(0, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

constexpr const char* kFolders[] = {kVersion, "samples", "sweeps", "maps", "can_bus", kFixFolder};

// True when nothing but a simulation is in `root`, so that it can be replaced as a whole.
bool IsEarlierSimulation(const fs::path& root) {
  std::error_code error;
  if (!fs::exists(root / kVersion / kRigFileName, error)) return false;
  for (const auto& entry : fs::directory_iterator(root, error)) {
    const std::string name = entry.path().filename().string();
    const bool is_ours =
        std::find(std::begin(kFolders), std::end(kFolders), name) != std::end(kFolders);
    if (!is_ours) return false;
  }
  return !error;
}

absl::Status RemoveEarlier(const fs::path& root) {
  for (const char* folder : kFolders) {
    std::error_code error;
    fs::remove_all(root / folder, error);
    if (error) return FileFailure(root / folder, "cannot remove the earlier simulation", error);
  }
  return absl::OkStatus();
}

absl::Status Prepare(const fs::path& root, bool force) {
  std::error_code error;
  fs::create_directories(root, error);
  if (error) return FileFailure(root, "cannot make the folder", error);
  if (IsEarlierSimulation(root)) return RemoveEarlier(root);
  const bool is_empty = fs::is_empty(root, error);
  if (error) return FileFailure(root, "cannot read the folder", error);
  if (!is_empty && !force) {
    return absl::FailedPreconditionError(
        absl::StrCat(root.string(),
                     ": is not empty and not (only) an earlier simulation; choose another folder"
                     " or force"));
  }
  return absl::OkStatus();
}

}  // namespace

struct NuScenesWriter::Tables {
  NuScenesTables tables;
  Rig rig;
  nlohmann::ordered_json parked = nlohmann::ordered_json::object();  ///< by the pass's name
};

NuScenesWriter::NuScenesWriter(fs::path root, std::unique_ptr<Tables> tables)
    : root_(std::move(root)), tables_(std::move(tables)) {}
NuScenesWriter::NuScenesWriter(NuScenesWriter&&) noexcept = default;
NuScenesWriter& NuScenesWriter::operator=(NuScenesWriter&&) noexcept = default;
NuScenesWriter::~NuScenesWriter() = default;

absl::StatusOr<NuScenesWriter> NuScenesWriter::Create(const fs::path& root, bool force) {
  if (absl::Status status = Prepare(root, force); !status.ok()) return status;
  return NuScenesWriter(root, std::make_unique<Tables>());
}

absl::Status NuScenesWriter::AddPass(const SimulatedPass& pass) {
  if (pass.drive.scans.empty()) {
    return absl::InvalidArgumentError(absl::StrCat("pass ", pass.drive.name, " has no scans"));
  }
  const StoredPass stored = PlanStorage(pass);
  for (std::size_t i = 0; i < stored.sweeps.size(); ++i) {
    const Scan& scan = pass.drive.scans[i].scan;
    const RadarModel* radar = pass.drive.rig.Find(scan.radar_id);
    if (radar == nullptr) {
      return absl::InvalidArgumentError(absl::StrCat("the rig has no radar ", scan.radar_id));
    }
    absl::Status status =
        WriteFile(root_ / stored.sweeps[i].filename, EncodeRadarPcd(scan, *radar));
    if (!status.ok()) return status;
  }
  tables_->tables.AddPass(pass, stored);
  tables_->rig = pass.drive.rig;
  tables_->parked[pass.drive.name] = ParkedVehicles(pass);
  return WriteJson(root_ / "can_bus" / (pass.drive.name + "_pose.json"), CanBusPose(pass));
}

absl::Status NuScenesWriter::AddFixes(const std::string& pass_name,
                                      const std::vector<StampedFix>& fixes) {
  const fs::path folder = root_ / kFixFolder;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return FileFailure(folder, "cannot make the folder", error);
  return WriteFixes(folder / (pass_name + ".csv"), fixes);
}

absl::Status NuScenesWriter::AddChanges(const std::vector<simulation::ScattererChange>& changes) {
  return WriteJson(root_ / kVersion / kChangesFileName,
                   {{"scatterers", ScattererChanges(changes)}, {"parked", tables_->parked}});
}

absl::Status NuScenesWriter::Finish(const SimulationOptions& options) {
  const fs::path folder = root_ / kVersion;
  absl::Status status = WriteFile(root_ / tables_->tables.map_filename(), kBlankPng);
  for (const auto& [name, table] : tables_->tables.All()) {
    status.Update(WriteJson(folder / (name + ".json"), table));
  }
  nlohmann::ordered_json rig = RigDescription(tables_->rig, options);
  // Left out where it says nothing, so that a simulation without it keeps its bytes.
  if (options.day != 0 || options.vehicle_count > 1 || ChangesWorld(options.ageing)) {
    rig["simulation"]["ageing"] = AgeingDescription(options);
  }
  status.Update(WriteJson(folder / kRigFileName, rig));
  return status;
}

}  // namespace dcloc
