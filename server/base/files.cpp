#include "server/base/files.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include "absl/strings/cord.h"
#include "absl/strings/str_cat.h"
#include "absl/types/optional.h"

namespace dcloc::server {
namespace {

/// Of a status: which file it is about.
constexpr char kPathPayload[] = "dcloc.path";

absl::StatusCode CodeOfErrno(int error) {
  switch (error) {
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
    case EMFILE:
    case ENFILE:
      return absl::StatusCode::kResourceExhausted;
    case ENOENT:
      return absl::StatusCode::kNotFound;
    default:
      return absl::StatusCode::kInternal;
  }
}

absl::Status ErrorOf(int error, absl::string_view doing) {
  const std::string reason = std::error_code(error, std::generic_category()).message();
  return absl::Status(CodeOfErrno(error),
                      absl::StrCat("a file of the store: ", doing, ": ", reason));
}

absl::Status ErrorOf(int error, absl::string_view doing, const std::filesystem::path& path) {
  return AboutFile(ErrorOf(error, doing), path);
}

absl::Status NotRegular(const std::filesystem::path& path) {
  return AboutFile(absl::DataLossError("not a regular file"), path);
}

absl::StatusOr<FileDescriptor> OpenFile(const std::filesystem::path& path, int flags) {
  constexpr int kOwnerOnly = 0600;
  int descriptor = -1;
  do {
    descriptor = open(path.c_str(), flags | O_CLOEXEC, kOwnerOnly);
  } while (descriptor < 0 && errno == EINTR);
  FileDescriptor file(descriptor);
  if (file.get() < 0) return errno == ELOOP ? NotRegular(path) : ErrorOf(errno, "open", path);
  return file;
}

}  // namespace

absl::Status FileError(const std::error_code& error, const std::filesystem::path& path) {
  return ErrorOf(error.value(), "access", path);
}

absl::Status WithPath(const absl::Status& status) {
  const absl::optional<absl::Cord> path = status.GetPayload(kPathPayload);
  if (!path) return status;
  return absl::Status(status.code(), absl::StrCat(std::string(*path), ": ", status.message()));
}

absl::Status AboutFile(absl::Status status, const std::filesystem::path& path) {
  status.SetPayload(kPathPayload, absl::Cord(path.string()));
  return status;
}

FileDescriptor::FileDescriptor(FileDescriptor&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)) {}

FileDescriptor& FileDescriptor::operator=(FileDescriptor&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

FileDescriptor::~FileDescriptor() {
  if (descriptor_ >= 0) close(descriptor_);
}

absl::StatusOr<FileDescriptor> OpenOrCreate(const std::filesystem::path& path) {
  return OpenFile(path, O_RDWR | O_CREAT);
}

absl::StatusOr<FileDescriptor> OpenToRead(const std::filesystem::path& path) {
  // Non-blocking, so that a pipe in place of a file cannot hold the caller.
  absl::StatusOr<FileDescriptor> file = OpenFile(path, O_RDONLY | O_NONBLOCK);
  struct stat properties {};
  if (!file.ok()) return file;
  if (fstat(file->get(), &properties) != 0) return ErrorOf(errno, "stat", path);
  if (!S_ISREG(properties.st_mode)) return NotRegular(path);
  return file;
}

absl::StatusOr<std::int64_t> FileSize(const FileDescriptor& file) {
  struct stat properties {};
  if (fstat(file.get(), &properties) != 0) return ErrorOf(errno, "stat");
  return std::int64_t{properties.st_size};
}

absl::Status WriteAll(const FileDescriptor& file, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(file.get(), bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return ErrorOf(errno, "write");
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::size_t> ReadUpTo(const FileDescriptor& file, std::span<std::byte> buffer) {
  std::size_t size = 0;
  while (size < buffer.size()) {
    const ssize_t count = read(file.get(), buffer.data() + size, buffer.size() - size);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return ErrorOf(errno, "read");
    if (count == 0) break;
    size += static_cast<std::size_t>(count);
  }
  return size;
}

absl::Status Truncate(const FileDescriptor& file, std::int64_t size_bytes) {
  const bool done = ftruncate(file.get(), size_bytes) == 0 && lseek(file.get(), 0, SEEK_SET) == 0;
  return done ? absl::OkStatus() : ErrorOf(errno, "truncate");
}

absl::StatusOr<std::int64_t> FileSize(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) return 0;
  const bool is_circle = error == std::errc::too_many_symbolic_link_levels;
  if (error && !is_circle) return ErrorOf(error.value(), "stat", path);
  if (!std::filesystem::is_regular_file(status)) return NotRegular(path);
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error == std::errc::no_such_file_or_directory) return 0;
  if (error) return ErrorOf(error.value(), "stat", path);
  return static_cast<std::int64_t>(size);
}

bool IsThere(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::symlink_status(path, error).type() !=
         std::filesystem::file_type::not_found;
}

absl::Status RemoveFile(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::remove(path, error);
  return error ? ErrorOf(error.value(), "remove", path) : absl::OkStatus();
}

absl::Status MoveFile(const std::filesystem::path& from, const std::filesystem::path& to) {
  std::error_code error;
  std::filesystem::rename(from, to, error);
  return error ? ErrorOf(error.value(), "rename", to) : absl::OkStatus();
}

absl::Status Sync(const FileDescriptor& file) {
  int result = 0;
  do {
    result = fsync(file.get());
  } while (result != 0 && errno == EINTR);
  return result == 0 ? absl::OkStatus() : ErrorOf(errno, "fsync");
}

absl::Status SyncFile(const std::filesystem::path& path) {
  const absl::StatusOr<FileDescriptor> file = OpenFile(path, O_RDONLY);
  return file.ok() ? Sync(*file) : file.status();
}

absl::Status SyncFolder(const std::filesystem::path& folder) {
  const absl::StatusOr<FileDescriptor> file = OpenFile(folder, O_RDONLY | O_DIRECTORY);
  return file.ok() ? Sync(*file) : file.status();
}

absl::Status CreateFolders(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  return error ? ErrorOf(error.value(), "mkdir", folder) : absl::OkStatus();
}

absl::StatusOr<FileDescriptor> LockFile(const std::filesystem::path& path) {
  absl::StatusOr<FileDescriptor> file = OpenFile(path, O_RDWR | O_CREAT);
  if (!file.ok()) return file.status();
  if (flock(file->get(), LOCK_EX | LOCK_NB) == 0) return file;
  if (errno != EWOULDBLOCK) return ErrorOf(errno, "flock", path);
  return absl::FailedPreconditionError(
      absl::StrCat(path.string(), " is held by another server; one folder serves one process"));
}

}  // namespace dcloc::server
