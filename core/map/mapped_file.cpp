#include "core/map/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "absl/strings/str_cat.h"

namespace dcloc {
namespace {

class FileDescriptor {
 public:
  // Non-blocking, so that a pipe in place of a file cannot hold the caller.
  explicit FileDescriptor(const std::filesystem::path& path)
      : value_(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {}
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  ~FileDescriptor() {
    if (value_ >= 0) close(value_);
  }
  int value() const { return value_; }

 private:
  int value_;
};

}  // namespace

absl::StatusOr<MappedFile> MappedFile::Open(const std::filesystem::path& path) {
  const FileDescriptor file(path);
  struct stat properties {};
  if (file.value() < 0 || fstat(file.value(), &properties) != 0) {
    return absl::ErrnoToStatus(errno, path.string());
  }
  if (!S_ISREG(properties.st_mode)) {
    return absl::DataLossError(absl::StrCat(path.string(), ": not a regular file"));
  }
  const auto size_bytes = static_cast<std::size_t>(properties.st_size);
  if (size_bytes == 0) return MappedFile({});
  void* const address = mmap(nullptr, size_bytes, PROT_READ, MAP_SHARED, file.value(), 0);
  if (address == MAP_FAILED) return absl::ErrnoToStatus(errno, path.string());
  return MappedFile({static_cast<const std::byte*>(address), size_bytes});
}

MappedFile::MappedFile(MappedFile&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}

MappedFile& MappedFile::operator=(MappedFile&& other) noexcept {
  std::swap(bytes_, other.bytes_);
  return *this;
}

MappedFile::~MappedFile() {
  if (bytes_.empty()) return;
  munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

void MappedFile::ExpectRandomReadsFrom(std::size_t offset_bytes) const {
  const auto page_bytes = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  const std::size_t begin_bytes = (offset_bytes + page_bytes - 1) / page_bytes * page_bytes;
  if (begin_bytes >= bytes_.size()) return;
  // Advice only: a kernel that does not take it still reads right.
  madvise(const_cast<std::byte*>(bytes_.data()) + begin_bytes, bytes_.size() - begin_bytes,
          MADV_RANDOM);
}

}  // namespace dcloc
