#include "client/trajectory/file_of_drive.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"

namespace dcloc {

std::filesystem::path FileOfDrive(const std::filesystem::path& file, const std::string& drive) {
  const std::string name = absl::StrReplaceAll(drive, {{"%", "%25"}, {"/", "%2F"}});
  return file.parent_path() /
         absl::StrCat(file.stem().string(), "-", name, file.extension().string());
}

}  // namespace dcloc
