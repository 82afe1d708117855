#include "client/cli/common/json_folder.h"

#include <array>
#include <cstdint>
#include <fstream>
#include <span>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "client/cli/common/atomic_file.h"

namespace dcloc::cli {

std::optional<nlohmann::json> JsonFolder::Load(const std::string& name) const {
  std::ifstream file(PathOf(name));
  if (!file) return std::nullopt;
  auto json = nlohmann::json::parse(file, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object() || !json.contains("outcome") ||
      json.value("fingerprint", nlohmann::json()) != fingerprint_) {
    return std::nullopt;
  }
  return std::move(json["outcome"]);
}

absl::Status JsonFolder::Save(const std::string& name, const nlohmann::json& result) const {
  const nlohmann::json json = {{"fingerprint", fingerprint_}, {"outcome", result}};
  const std::string text = json.dump();
  return WriteFileAtomically(PathOf(name), std::as_bytes(std::span(text)));
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

absl::Status MakeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error) return absl::OkStatus();
  return absl::UnavailableError(
      absl::StrCat(folder.string(), ": cannot be made: ", error.message()));
}

}  // namespace dcloc::cli
