#include "client/cli/map/map_files.h"

#include <filesystem>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/cli/common/atomic_file.h"
#include "client/cli/common/output_file.h"

namespace dcloc::cli {
namespace {

absl::Status Named(const std::string& file, const absl::Status& status) {
  return absl::Status(status.code(), absl::StrCat(file, ": ", status.message()));
}

absl::Status CheckFolder(const std::string& file) {
  const std::filesystem::path folder = std::filesystem::path(file).parent_path();
  std::error_code error;
  if (!folder.empty() && !std::filesystem::is_directory(folder, error)) {
    return absl::NotFoundError(
        absl::StrCat(file, ": cannot be written: there is no folder ", folder.string()));
  }
  if (!std::filesystem::is_directory(file, error)) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(file, ": cannot be written: it is a folder"));
}

}  // namespace

absl::Status CheckFolders(const std::vector<std::string>& files) {
  for (const std::string& file : files) {
    if (file.empty()) continue;
    if (absl::Status status = CheckFolder(file); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::StatusOr<EditableMap> ReadMapParts(const std::string& file) {
  const auto map = RadarMap::Open(file);
  if (!map.ok()) return map.status();
  if (absl::Status status = (*map)->Verify(); !status.ok()) return Named(file, status);
  return ToEditable(**map);
}

absl::StatusOr<MapInfo> WriteMapParts(const EditableMap& map, const std::string& file) {
  MadeFile made{.file = file, .bytes = {}};
  absl::StatusOr<MapInfo> info = MakeMapFile(map, made);
  if (!info.ok()) return info;
  if (absl::Status status = WriteFileAtomically(file, made.bytes); !status.ok()) return status;
  return info;
}

absl::StatusOr<MapInfo> MakeMapFile(const EditableMap& map, MadeFile& made) {
  absl::StatusOr<std::vector<std::byte>> bytes = ToMapBytes(map);
  if (!bytes.ok()) return Named(made.file, bytes.status());
  const auto read = RadarMap::FromBytes(*bytes);
  if (!read.ok()) return Named(made.file, read.status());
  made.bytes = *std::move(bytes);
  return (*read)->info();
}

absl::Status WriteMadeFiles(const std::vector<MadeFile>& files, bool force) {
  OutputFiles outputs{.paths = {}, .force = force};
  for (const MadeFile& made : files) outputs.paths.push_back(made.file);
  absl::Status status = CheckOutputFiles(outputs);
  for (const MadeFile& made : files) status.Update(CheckFolder(made.file));
  for (const MadeFile& made : files) {
    if (status.ok()) status = WriteFileAtomically(made.file, made.bytes);
  }
  return status;
}

}  // namespace dcloc::cli
