#include "client/cli/run_folder.h"

#include <array>
#include <cstdint>
#include <fstream>
#include <span>

#include "absl/strings/str_cat.h"
#include "client/cli/atomic_file.h"
#include "client/evaluation/paper/outcome_json.h"

namespace dcloc::cli {

std::optional<DriveOutcome> RunFolder::Load(const std::string& run_name) {
  std::ifstream file(PathOf(run_name));
  if (!file) return std::nullopt;
  const auto json = nlohmann::json::parse(file, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object() || !json.contains("outcome") ||
      json.value("fingerprint", nlohmann::json()) != fingerprint_) {
    return std::nullopt;
  }
  return paper::OutcomeFromJson(json["outcome"]);
}

absl::Status RunFolder::Save(const std::string& run_name, const DriveOutcome& outcome) {
  const nlohmann::json json = {{"fingerprint", fingerprint_},
                               {"outcome", paper::OutcomeToJson(outcome)}};
  const std::string text = json.dump();
  return WriteFileAtomically(PathOf(run_name), std::as_bytes(std::span(text)));
}

// FNV-1a, 64 bits.
std::string ProgramHash() {
  std::ifstream program("/proc/self/exe", std::ios::binary);
  std::uint64_t hash = 0xcbf29ce484222325U;
  std::array<char, 1 << 16> buffer{};
  while (program.read(buffer.data(), buffer.size()) || program.gcount() > 0) {
    for (const char byte : std::span(buffer).first(static_cast<std::size_t>(program.gcount()))) {
      hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3U;
    }
  }
  return absl::StrCat(absl::Hex(hash, absl::kZeroPad16));
}

}  // namespace dcloc::cli
