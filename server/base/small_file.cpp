#include "server/base/small_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "absl/strings/str_cat.h"
#include "server/base/files.h"

namespace dcloc::server {
namespace {

absl::Status CannotBeRead(const std::filesystem::path& path, int error) {
  return absl::InvalidArgumentError(
      absl::StrCat(path.string(), ": cannot be read: ", std::strerror(error)));
}

}  // namespace

absl::StatusOr<std::string> ReadSmallFile(const std::filesystem::path& path,
                                          std::size_t max_bytes) {
  const FileDescriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.get() < 0) {
    return absl::NotFoundError(
        absl::StrCat(path.string(), ": cannot be read: ", std::strerror(errno)));
  }
  struct stat found {};
  if (fstat(file.get(), &found) != 0) return CannotBeRead(path, errno);
  if (!S_ISREG(found.st_mode)) {
    return absl::InvalidArgumentError(absl::StrCat(path.string(), ": is no regular file"));
  }
  // With a byte more than it has, which its end leaves free.
  std::string text(std::min(static_cast<std::size_t>(found.st_size), max_bytes) + 1, '\0');
  std::size_t size = 0;
  while (size < text.size()) {
    const ssize_t got = read(file.get(), text.data() + size, text.size() - size);
    if (got < 0) return CannotBeRead(path, errno);
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
    const bool has_grown = size == text.size();
    if (has_grown) text.resize(std::min(2 * size, max_bytes + 1));
  }
  if (size > max_bytes) {
    return absl::InvalidArgumentError(
        absl::StrCat(path.string(), ": is larger than ", max_bytes, " bytes"));
  }
  text.resize(size);
  return text;
}

}  // namespace dcloc::server
