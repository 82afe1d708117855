#include "server/objects/object_store.h"

#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <thread>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "server/base/sha256.h"
#include "server/base/status.h"
#include "server/base/within_memory.h"
#include "server/objects/object_credentials.h"
#include "server/objects/object_error.h"
#include "server/objects/response_status.h"
#include "server/objects/s3_xml.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

using Clock = std::chrono::steady_clock;

/// As a value of a query: keys have no other character that needs it.
std::string Encoded(absl::string_view key) { return absl::StrReplaceAll(key, {{"/", "%2F"}}); }

std::string Sha256OfText(absl::string_view text) {
  Sha256 hash;
  hash.Update(std::as_bytes(std::span(text)));
  return hash.Finish();
}

S3Options S3OptionsOf(const ObjectOptions& options) {
  constexpr int kConnectShare = 4;  // so that each attempt has its time
  return {.region = options.region,
          .ca_file = options.ca_file,
          .connect_timeout = options.timeout / kConnectShare,
          .pause_timeout = options.timeout,
          .min_rate_bytes_per_s = options.min_rate_bytes_per_s};
}

std::chrono::milliseconds TimeOf(const S3Request& request, const ObjectOptions& options) {
  const auto size_bytes =
      static_cast<double>(request.body.size_bytes) + static_cast<double>(request.sink.size());
  const std::chrono::duration<double> body(size_bytes / options.min_rate_bytes_per_s);
  return options.timeout + std::chrono::ceil<std::chrono::milliseconds>(body);
}

bool IsAnswer(const absl::Status& status) {
  return status.ok() || absl::IsNotFound(status) || absl::IsOutOfRange(status);
}

S3Body BodyOf(absl::string_view text) {
  return {.size_bytes = static_cast<std::int64_t>(text.size()),
          .read = [text](std::int64_t offset, std::span<std::byte> buffer) {
            const absl::string_view rest = text.substr(static_cast<std::size_t>(offset));
            const std::size_t size = std::min(rest.size(), buffer.size());
            std::memcpy(buffer.data(), rest.data(), size);
            return size;
          }};
}

}  // namespace

absl::StatusOr<std::unique_ptr<ObjectStore>> ObjectStore::Open(const ObjectOptions& options) {
  if (absl::Status status = Validate(options); !status.ok()) return status;
  absl::Status status = ReadObjectCredentials(options.credentials_file).status();
  if (!status.ok()) return status;
  return std::unique_ptr<ObjectStore>(
      new ObjectStore(options, *ParseObjectLocation(options.location)));
}

ObjectStore::ObjectStore(const ObjectOptions& options, ObjectLocation location)
    : options_(options),
      location_(std::move(location)),
      client_(S3OptionsOf(options)),
      breaker_(options.away_interval) {}

std::string ObjectStore::UrlOf(absl::string_view key) const {
  return absl::StrCat(options_.endpoint, "/", location_.bucket, "/", location_.prefix, key);
}

absl::Status ObjectStore::Put(absl::string_view key, const FileDescriptor& file,
                              std::int64_t size_bytes, absl::string_view sha256) {
  S3Body body{.size_bytes = size_bytes,
              .read = [&file](std::int64_t offset, std::span<std::byte> buffer) {
                const ssize_t size = pread(file.get(), buffer.data(), buffer.size(), offset);
                return static_cast<std::size_t>(std::max(ssize_t{0}, size));
              }};
  return PutBody(key, std::move(body), sha256);
}

absl::Status ObjectStore::PutText(absl::string_view key, absl::string_view text) {
  return PutBody(key, BodyOf(text), Sha256OfText(text));
}

absl::Status ObjectStore::PutBody(absl::string_view key, S3Body body, absl::string_view sha256) {
  const std::int64_t size_bytes = body.size_bytes;
  absl::Status status =
      Ask({.method = "PUT", .url = UrlOf(key), .body = std::move(body)}, sha256).status();
  if (status.ok()) counts_.written_bytes += size_bytes;
  return status;
}

absl::Status ObjectStore::Read(absl::string_view key, std::int64_t offset_bytes,
                               std::span<std::byte> bytes) {
  while (!bytes.empty()) {
    const std::size_t size =
        std::min(bytes.size(), static_cast<std::size_t>(options_.max_range_bytes));
    const std::int64_t last = offset_bytes + static_cast<std::int64_t>(size) - 1;
    const absl::StatusOr<S3Answer> answer = Ask({.method = "GET",
                                                 .url = UrlOf(key),
                                                 .range = absl::StrCat(offset_bytes, "-", last),
                                                 .sink = bytes.first(size)},
                                                Sha256OfText(""));
    if (absl::IsOutOfRange(answer.status())) {
      return absl::DataLossError(
          absl::StrCat("the object is shorter than ", offset_bytes, " bytes"));
    }
    if (!answer.ok()) return answer.status();
    counts_.read_bytes += static_cast<std::int64_t>(size);
    offset_bytes += static_cast<std::int64_t>(size);
    bytes = bytes.subspan(size);
  }
  return absl::OkStatus();
}

absl::StatusOr<std::string> ObjectStore::ReadText(absl::string_view key) {
  absl::StatusOr<S3Answer> answer = Ask({.method = "GET", .url = UrlOf(key)}, Sha256OfText(""));
  if (!answer.ok()) return answer.status();
  counts_.read_bytes += static_cast<std::int64_t>(answer->text.size());
  return std::move(answer->text);
}

absl::StatusOr<std::int64_t> ObjectStore::SizeOf(absl::string_view key) {
  const absl::StatusOr<S3Answer> answer =
      Ask({.method = "HEAD", .url = UrlOf(key)}, Sha256OfText(""));
  if (!answer.ok()) return answer.status();
  if (answer->size_bytes >= 0) return answer->size_bytes;
  return ObjectStoreError("the service says no size of an object");
}

absl::Status ObjectStore::Copy(absl::string_view from, absl::string_view to) {
  const std::string source =
      absl::StrCat("x-amz-copy-source: /", location_.bucket, "/", location_.prefix, from);
  return Ask({.method = "PUT", .url = UrlOf(to), .headers = {source}}, Sha256OfText("")).status();
}

absl::Status ObjectStore::Remove(absl::string_view key) {
  absl::Status status = Ask({.method = "DELETE", .url = UrlOf(key)}, Sha256OfText("")).status();
  return absl::IsNotFound(status) ? absl::OkStatus() : status;
}

absl::StatusOr<std::map<std::string, std::int64_t>> ObjectStore::List(absl::string_view prefix) {
  const std::string whole = absl::StrCat(location_.prefix, prefix);
  std::map<std::string, std::int64_t> objects;
  std::string last;
  while (true) {
    // In the order in which it is signed.
    const std::string query = absl::StrCat("list-type=2&max-keys=1000&prefix=", Encoded(whole),
                                           last.empty() ? "" : "&start-after=", Encoded(last));
    const std::string url = absl::StrCat(options_.endpoint, "/", location_.bucket, "?", query);
    const absl::StatusOr<S3Answer> answer = Ask({.method = "GET", .url = url}, Sha256OfText(""));
    if (absl::IsNotFound(answer.status())) return ObjectStoreError("there is no such bucket");
    if (!answer.ok()) return answer.status();
    const absl::StatusOr<S3Page> page = ParseS3Page(answer->text);
    if (!page.ok()) return ObjectStoreError(page.status().message());
    for (const auto& [key, size_bytes] : page->objects) {
      if (key <= last) return ObjectStoreError("the service repeats itself in a list of objects");
      last = key;
      if (absl::string_view(key).substr(0, whole.size()) != whole) continue;
      objects[key.substr(whole.size())] = size_bytes;
    }
    if (page->is_last) return objects;
    if (page->objects.empty()) return ObjectStoreError("a list of objects does not end");
  }
}

absl::StatusOr<S3Answer> ObjectStore::Ask(S3Request request, absl::string_view body_sha256) {
  const absl::StatusOr<CircuitBreaker::Pass> pass = breaker_.Enter();
  if (!pass.ok()) return pass.status();
  const int attempt_count = *pass == CircuitBreaker::Pass::kProbe ? 1 : options_.max_attempt_count;
  const Clock::time_point end = Clock::now() + options_.timeout;
  request.timeout = TimeOf(request, options_);
  auto pause = options_.first_pause;
  absl::StatusOr<S3Answer> answer;
  for (int attempt = 1;; ++attempt, pause *= 2) {
    answer = OutOfMemory();
    WithinMemory([&] { answer = AskOnce(request, body_sha256); }).IgnoreError();
    if (!absl::IsUnavailable(answer.status())) break;
    if (attempt >= attempt_count || Clock::now() + pause >= end) break;
    ++counts_.repeated;
    std::this_thread::sleep_for(pause);
  }
  const bool answered = IsAnswer(answer.status());
  ++(answered ? counts_.answered : counts_.failed);
  // What was not asked says nothing, so that it is looked for again.
  const bool is_there =
      !absl::IsUnavailable(answer.status()) && !absl::IsResourceExhausted(answer.status());
  breaker_.Note(is_there ? absl::OkStatus() : answer.status());
  if (answered) return answer;
  const absl::Status& status = answer.status();
  if (absl::IsFailedPrecondition(status)) {
    spdlog::error("object store refuses method={} reason={}", request.method,
                  Quoted(status.message()));
  }
  return ObjectStoreError(status.message());
}

absl::StatusOr<S3Answer> ObjectStore::AskOnce(const S3Request& request,
                                              absl::string_view body_sha256) {
  const absl::StatusOr<ObjectCredentials> credentials =
      ReadObjectCredentials(options_.credentials_file);
  if (!credentials.ok()) return absl::FailedPreconditionError(credentials.status().message());
  absl::StatusOr<S3Answer> answer = client_.Send(request, body_sha256, *credentials);
  if (!answer.ok()) return answer;
  absl::Status status = StatusOfResponse(request, *answer);
  if (!status.ok()) return status;
  return answer;
}

}  // namespace dcloc::server
