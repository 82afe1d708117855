#include "server/maps/store/map_bucket.h"

#include <algorithm>
#include <map>
#include <span>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/base/files.h"
#include "server/base/sha256.h"
#include "server/maps/store/map_folder.h"
#include "server/maps/store/read_map.h"
#include "server/objects/object_error.h"

namespace dcloc::server {
namespace {

constexpr char kMapsFolder[] = "maps/";
constexpr char kQuarantineFolder[] = "quarantine/";
constexpr char kAges[] = "quarantine.ages";
/// That are read at once where nobody wants all of a file.
constexpr std::int64_t kCheckPiece_bytes = std::int64_t{4} << 20;

std::string KeyOf(absl::string_view sha256) {
  return MapFolder::PathIn(kMapsFolder, sha256).generic_string();
}

std::string QuarantineKeyOf(absl::string_view sha256) {
  return absl::StrCat(kQuarantineFolder, MapFolder::PathIn("", sha256).filename().string());
}

ServedAges::Place AgesIn(const std::shared_ptr<ObjectStore>& objects) {
  return {.load = [objects]() -> absl::StatusOr<std::string> {
            absl::StatusOr<std::string> text = objects->ReadText(kAges);
            return absl::IsNotFound(text.status()) ? "" : std::move(text);
          },
          .save = [objects](const std::string& text) { return objects->PutText(kAges, text); }};
}

}  // namespace

MapBucket::MapBucket(std::shared_ptr<ObjectStore> objects)
    : objects_(std::move(objects)), ages_(AgesIn(objects_)) {}

absl::Status MapBucket::Keep(const std::filesystem::path& path, absl::string_view sha256) {
  const absl::StatusOr<FileDescriptor> file = OpenToRead(path);
  if (!file.ok()) return file.status();
  const absl::StatusOr<std::int64_t> size_bytes = FileSize(*file);
  if (!size_bytes.ok()) return size_bytes.status();
  absl::Status status = objects_->Put(KeyOf(sha256), *file, *size_bytes, sha256);
  if (status.ok()) status = Check(sha256, [](std::size_t) { return true; });
  if (absl::IsNotFound(status) || absl::IsDataLoss(status)) {
    return ObjectStoreError(absl::StrCat("it has not what was stored: ", status.message()));
  }
  return status.ok() ? RemoveFile(path) : status;
}

absl::StatusOr<std::vector<std::byte>> MapBucket::Read(absl::string_view sha256) {
  const std::string key = KeyOf(sha256);
  absl::StatusOr<std::vector<std::byte>> bytes = ReadOnce(key, sha256);
  // On their way they may have changed as well.
  return absl::IsDataLoss(bytes.status()) ? ReadOnce(key, sha256) : std::move(bytes);
}

absl::StatusOr<std::vector<std::byte>> MapBucket::ReadOnce(const std::string& key,
                                                           absl::string_view sha256) {
  const absl::StatusOr<std::int64_t> size_bytes = objects_->SizeOf(key);
  if (!size_bytes.ok()) return size_bytes.status();
  absl::StatusOr<std::vector<std::byte>> bytes = MemoryForMap(*size_bytes);
  if (!bytes.ok()) return bytes;
  Sha256 hash;
  absl::Status status = objects_->Read(key, 0, *bytes);
  if (status.ok()) hash.Update(*bytes);
  if (status.ok()) status = CheckMapHash(hash, sha256);
  if (!status.ok()) return status;
  return bytes;
}

absl::Status MapBucket::Check(absl::string_view sha256, absl::FunctionRef<bool(std::size_t)> pace) {
  const std::string key = KeyOf(sha256);
  const absl::StatusOr<std::int64_t> size_bytes = objects_->SizeOf(key);
  if (!size_bytes.ok()) return size_bytes.status();
  std::vector<std::byte> buffer(static_cast<std::size_t>(std::min(*size_bytes, kCheckPiece_bytes)));
  Sha256 hash;
  for (std::int64_t offset = 0; offset < *size_bytes; offset += kCheckPiece_bytes) {
    const auto size = static_cast<std::size_t>(std::min(kCheckPiece_bytes, *size_bytes - offset));
    const auto piece = std::span(buffer).first(size);
    if (absl::Status status = objects_->Read(key, offset, piece); !status.ok()) return status;
    hash.Update(piece);
    if (!pace(size)) return absl::CancelledError("stopped");
  }
  return CheckMapHash(hash, sha256);
}

absl::Status MapBucket::Remove(absl::string_view sha256) { return objects_->Remove(KeyOf(sha256)); }

absl::Status MapBucket::Quarantine(absl::string_view sha256) {
  const std::string from = KeyOf(sha256);
  const std::string to = QuarantineKeyOf(sha256);
  // One of that name may have been there for long.
  absl::Status status = ages_.Forget(to.substr(std::string(kQuarantineFolder).size()));
  if (status.ok()) status = objects_->Copy(from, to);
  if (!status.ok()) return status;
  const absl::StatusOr<std::int64_t> wanted = objects_->SizeOf(from);
  if (!wanted.ok()) return wanted.status();
  const absl::StatusOr<std::int64_t> copied = objects_->SizeOf(to);
  if (!copied.ok() || *copied != *wanted) {
    return ObjectStoreError("a copy of an object is not whole");
  }
  return objects_->Remove(from);
}

absl::StatusOr<int> MapBucket::RemoveExpiredQuarantine(std::chrono::nanoseconds served,
                                                       std::chrono::nanoseconds limit) {
  const auto sizes = objects_->List(kQuarantineFolder);
  if (!sizes.ok()) return sizes.status();
  const auto ages = ages_.Advance(served, *sizes);
  if (!ages.ok()) return ages.status();
  int count = 0;
  for (const auto& [name, age] : *ages) {
    if (age < limit) continue;
    absl::Status status = objects_->Remove(absl::StrCat(kQuarantineFolder, name));
    if (!status.ok()) return status;
    ++count;
  }
  return count;
}

absl::StatusOr<int> MapBucket::QuarantinedCount() {
  const auto objects = objects_->List(kQuarantineFolder);
  if (!objects.ok()) return objects.status();
  return static_cast<int>(objects->size());
}

absl::StatusOr<std::int64_t> MapBucket::SizeOf(absl::string_view sha256) {
  absl::StatusOr<std::int64_t> size_bytes = objects_->SizeOf(KeyOf(sha256));
  return absl::IsNotFound(size_bytes.status()) ? 0 : std::move(size_bytes);
}

absl::StatusOr<std::vector<std::string>> MapBucket::List() {
  const auto objects = objects_->List(kMapsFolder);
  if (!objects.ok()) return objects.status();
  std::vector<std::string> hashes;
  for (const auto& [name, size_bytes] : *objects) {
    std::string hash = MapFolder::HashOf(name);
    if (!hash.empty()) hashes.push_back(std::move(hash));
  }
  return hashes;
}

}  // namespace dcloc::server
