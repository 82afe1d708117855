#include "client/cli/common/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace dcloc::cli {
namespace {

absl::Status SystemError(const std::filesystem::path& path, const char* what) {
  return absl::ErrnoToStatus(errno, absl::StrCat(path.string(), ": cannot ", what));
}

absl::Status WriteAll(int file, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return absl::ErrnoToStatus(errno, "cannot write");
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  if (fsync(file) != 0) return absl::ErrnoToStatus(errno, "cannot write");
  return absl::OkStatus();
}

// What open(2) would give a new file; mkstemp gives 0600, which the server could not read. The mask
// can only be read by changing it, for all threads: so it is, before there is a second one.
const mode_t kDefaultMode = [] {
  const mode_t mask = umask(0);
  umask(mask);
  return 0666 & ~mask;
}();

}  // namespace

absl::Status WriteFileAtomically(const std::filesystem::path& path,
                                 std::span<const std::byte> bytes) {
  std::string temporary = absl::StrCat(path.string(), ".XXXXXX");
  const int file = mkstemp(temporary.data());
  if (file < 0) return SystemError(path, "be written");
  absl::Status status = WriteAll(file, bytes);
  if (!status.ok()) {
    status = absl::Status(status.code(), absl::StrCat(path.string(), ": ", status.message()));
  }
  if (status.ok() && fchmod(file, kDefaultMode) != 0) status = SystemError(path, "set the mode");
  if (close(file) != 0 && status.ok()) status = SystemError(path, "write");
  if (status.ok() && rename(temporary.c_str(), path.c_str()) != 0) {
    status = SystemError(path, "replace");
  }
  if (!status.ok()) unlink(temporary.c_str());
  return status;
}

}  // namespace dcloc::cli
