#include "server/maps/jobs/scan_spool.h"

#include <span>
#include <string>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/base/framed_file.h"
#include "server/base/random_name.h"

namespace dcloc::server {
namespace {

absl::Status CannotWrite() {
  return absl::ResourceExhaustedError("the scans cannot be written: the disk may be full");
}

}  // namespace

ScanSpool::ScanSpool(std::filesystem::path path)
    : path_(std::move(path)), out_(path_, std::ios::binary | std::ios::trunc) {}

ScanSpool::~ScanSpool() {
  std::error_code error;
  std::filesystem::remove(path_, error);
}

absl::StatusOr<std::unique_ptr<ScanSpool>> ScanSpool::Create(const std::filesystem::path& folder) {
  const absl::StatusOr<std::string> name = RandomName(64, "a build's scans");
  if (!name.ok()) return name.status();
  std::unique_ptr<ScanSpool> spool(new ScanSpool(folder / absl::StrCat("build-", *name)));
  if (!spool->out_) return CannotWrite();
  return spool;
}

absl::Status ScanSpool::Append(const v1::StartMapBuildRequest& message, std::int64_t max_bytes) {
  buffer_.clear();
  AppendFramed(message, &buffer_);
  size_bytes_ += static_cast<std::int64_t>(buffer_.size());
  if (size_bytes_ > max_bytes) {
    return absl::ResourceExhaustedError(
        absl::StrFormat("the scans have more than %d MiB, which is max_map_mib", max_bytes >> 20));
  }
  out_.write(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
  hash_.Update(std::as_bytes(std::span(buffer_)));
  return out_ ? absl::OkStatus() : CannotWrite();
}

absl::StatusOr<std::string> ScanSpool::Finish() {
  out_.close();
  if (!out_) return CannotWrite();
  return hash_.Finish();
}

}  // namespace dcloc::server
