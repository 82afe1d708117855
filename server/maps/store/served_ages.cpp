#include "server/maps/store/served_ages.h"

#include <fstream>
#include <iterator>
#include <span>
#include <sstream>

#include "absl/strings/str_cat.h"
#include "server/base/files.h"

namespace dcloc::server {
namespace {

std::string TextIn(const std::filesystem::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

absl::Status Replace(const std::filesystem::path& path, const std::string& text) {
  const std::filesystem::path next = path.string() + ".next";
  const absl::StatusOr<FileDescriptor> file = OpenOrCreate(next);
  absl::Status status = file.status();
  if (status.ok()) status = Truncate(*file, 0);
  if (status.ok()) status = WriteAll(*file, std::as_bytes(std::span(text)));
  return status.ok() ? MoveFile(next, path) : status;
}

}  // namespace

ServedAges::ServedAges(const std::filesystem::path& path)
    : ServedAges(Place{.load = [path] { return TextIn(path); },
                       .save = [path](const std::string& text) { return Replace(path, text); }}) {}

absl::StatusOr<std::map<std::string, ServedAges::Age>> ServedAges::Advance(
    Age served, const std::map<std::string, std::int64_t>& sizes) {
  const std::lock_guard lock(mutex_);
  const absl::StatusOr<Entries> loaded = Load();
  if (!loaded.ok()) return loaded.status();
  const Entries& before = *loaded;
  Entries entries;
  std::map<std::string, Age> ages;
  for (const auto& [name, size_bytes] : sizes) {
    const auto known = before.find(name);
    const bool same = known != before.end() && known->second.size_bytes == size_bytes;
    const Age age = same ? known->second.age + served : Age::zero();
    entries[name] = {.age = age, .size_bytes = size_bytes};
    ages[name] = age;
  }
  // A full disk does not keep a server from starting: at the start there is nothing to add.
  if (served == Age::zero() || entries == before) return ages;
  if (absl::Status status = Save(entries); !status.ok()) return status;
  return ages;
}

absl::StatusOr<int> ServedAges::RemoveAged(Age served, Age limit,
                                           const std::vector<std::filesystem::path>& files) {
  std::map<std::string, std::int64_t> sizes;
  for (const std::filesystem::path& file : files) {
    const absl::StatusOr<std::int64_t> size = FileSize(file);
    if (!size.ok()) return size.status();
    sizes[file.filename().string()] = *size;
  }
  const auto ages = Advance(served, sizes);
  if (!ages.ok()) return ages.status();
  int count = 0;
  for (const std::filesystem::path& file : files) {
    if (ages->at(file.filename().string()) < limit) continue;
    if (absl::Status status = RemoveFile(file); !status.ok()) return status;
    ++count;
  }
  return count;
}

absl::Status ServedAges::Forget(const std::string& name) {
  const std::lock_guard lock(mutex_);
  absl::StatusOr<Entries> entries = Load();
  if (!entries.ok()) return entries.status();
  return entries->erase(name) == 0 ? absl::OkStatus() : Save(*entries);
}

absl::StatusOr<ServedAges::Entries> ServedAges::Load() const {
  const absl::StatusOr<std::string> kept = place_.load();
  if (!kept.ok()) return kept.status();
  std::istringstream text(*kept);
  Entries entries;
  std::int64_t age_ns = 0;
  std::int64_t size_bytes = 0;
  std::string name;
  while (text >> age_ns >> size_bytes && text.get() == ' ' && std::getline(text, name)) {
    if (age_ns >= 0) entries[name] = {.age = Age(age_ns), .size_bytes = size_bytes};
  }
  return entries;
}

absl::Status ServedAges::Save(const Entries& entries) const {
  std::string text;
  for (const auto& [name, entry] : entries) {
    absl::StrAppend(&text, entry.age.count(), " ", entry.size_bytes, " ", name, "\n");
  }
  return place_.save(text);
}

}  // namespace dcloc::server
