#include "server/maps/jobs/scan_spool.h"

#include <string>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/base/random_name.h"

namespace dcloc::server {
namespace {

using Length = std::uint32_t;

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

absl::Status ScanSpool::Append(const v1::PosedScan& scan, std::int64_t max_bytes) {
  const auto length = static_cast<Length>(scan.ByteSizeLong());
  size_bytes_ += static_cast<std::int64_t>(sizeof(length) + length);
  if (size_bytes_ > max_bytes) {
    return absl::ResourceExhaustedError(
        absl::StrFormat("the scans have more than %d MiB, which is max_map_mib", max_bytes >> 20));
  }
  scan.SerializeToString(&buffer_);
  out_.write(reinterpret_cast<const char*>(&length), sizeof(length));
  out_.write(buffer_.data(), length);
  if (!out_) return CannotWrite();
  ++scan_count_;
  return absl::OkStatus();
}

absl::Status ScanSpool::BeginReading() {
  if (out_.is_open()) {
    out_.close();
    if (!out_) return CannotWrite();
  }
  if (in_.is_open()) in_.close();
  in_.clear();
  in_.open(path_, std::ios::binary);
  return in_ ? absl::OkStatus() : absl::InternalError("the scans cannot be read again");
}

absl::StatusOr<bool> ScanSpool::Next(v1::PosedScan* scan) {
  Length length = 0;
  in_.read(reinterpret_cast<char*>(&length), sizeof(length));
  if (in_.eof() && in_.gcount() == 0) return false;
  // What was written was within a message's limit; anything else is a broken disk.
  if (in_ && length <= static_cast<std::uint64_t>(size_bytes_)) {
    buffer_.resize(length);
    in_.read(buffer_.data(), length);
    if (in_ && scan->ParseFromString(buffer_)) return true;
  }
  return absl::DataLossError("the scans cannot be read again");
}

}  // namespace dcloc::server
