#include "server/passes/pass_key.h"

#include <algorithm>
#include <span>
#include <system_error>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "server/base/files.h"
#include "server/base/random_name.h"
#include "server/base/small_file.h"

namespace dcloc::server {
namespace {

constexpr std::size_t kDigits = 64;

absl::Status Wrong(const std::filesystem::path& file, absl::string_view what) {
  return absl::InvalidArgumentError(absl::StrCat("pass_key: ", file.string(), ": ", what));
}

absl::Status CheckIsPrivate(const std::filesystem::path& file) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::perms others = fs::perms::others_all | fs::perms::group_write;
  const fs::perms mode = fs::status(file, error).permissions();
  if (error || (mode & others) == fs::perms::none) return absl::OkStatus();
  return Wrong(file, "others may read or change it; run chmod o-rwx,g-w on it");
}

}  // namespace

absl::StatusOr<std::string> ReadPassKey(const std::filesystem::path& file) {
  absl::StatusOr<std::string> text = ReadSmallFile(file);
  if (!text.ok())
    return absl::Status(text.status().code(), absl::StrCat("pass_key: ", text.status().message()));
  if (absl::Status status = CheckIsPrivate(file); !status.ok()) return status;
  const absl::string_view digits = absl::StripAsciiWhitespace(*text);
  if (digits.size() != kDigits || !std::ranges::all_of(digits, absl::ascii_isxdigit)) {
    return Wrong(file, absl::StrCat("it must have ", kDigits, " hexadecimal digits"));
  }
  return absl::HexStringToBytes(digits);
}

absl::StatusOr<std::string> ReadOrMakePassKey(const std::filesystem::path& file) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (fs::exists(file, error)) return ReadPassKey(file);
  absl::StatusOr<std::string> digits = RandomName(256, "a key of pseudonyms");
  if (!digits.ok()) return digits.status();
  const fs::path partial = file.string() + ".partial";
  const absl::StatusOr<FileDescriptor> made = OpenOrCreate(partial);
  if (!made.ok()) return made.status();
  fs::permissions(partial, fs::perms::owner_read | fs::perms::owner_write, error);
  absl::Status status = WriteAll(*made, std::as_bytes(std::span(*digits)));
  if (status.ok()) status = Sync(*made);
  if (status.ok()) status = MoveFile(partial, file);
  if (status.ok()) status = SyncFolder(file.parent_path());
  if (!status.ok()) return status;
  return absl::HexStringToBytes(*digits);
}

}  // namespace dcloc::server
