#include "client/cli/map/survey_checkpoint_file.h"

#include <filesystem>
#include <fstream>
#include <system_error>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/cli/common/atomic_file.h"

namespace dcloc::cli {

absl::StatusOr<std::vector<std::byte>> SurveyCheckpointFile::Read() {
  std::error_code error;
  if (!std::filesystem::exists(path_, error)) return std::vector<std::byte>();
  const std::uintmax_t size = std::filesystem::file_size(path_, error);
  std::ifstream file(path_, std::ios::binary);
  std::vector<std::byte> bytes(error ? 0 : size);
  if (error || !file.read(reinterpret_cast<char*>(bytes.data()),
                          static_cast<std::streamsize>(bytes.size()))) {
    return absl::NotFoundError(absl::StrCat(path_, ": the checkpoint cannot be read"));
  }
  return bytes;
}

absl::Status SurveyCheckpointFile::Write(std::span<const std::byte> bytes) {
  return WriteFileAtomically(path_, bytes);
}

void SurveyCheckpointFile::Remove() const {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

SurveyCheckpointStore* SurveyCheckpointFiles::OfRound(int round) {
  if (path_.empty()) return nullptr;
  const std::string path = round == 0 ? path_ : absl::StrCat(path_, ".", round);
  return &files_.try_emplace(round, path).first->second;
}

void SurveyCheckpointFiles::Remove() const {
  for (const auto& [round, file] : files_) file.Remove();
}

}  // namespace dcloc::cli
