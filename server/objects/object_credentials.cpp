#include "server/objects/object_credentials.h"

#include <cstdlib>
#include <map>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/string_view.h"
#include "server/base/small_file.h"
#include "server/base/status.h"

namespace dcloc::server {
namespace {

using Values = std::map<std::string, std::string, std::less<>>;

constexpr char kAccessKey[] = "aws_access_key_id";
constexpr char kSecretKey[] = "aws_secret_access_key";
constexpr char kSessionToken[] = "aws_session_token";

Values OfEnvironment() {
  Values values;
  for (const char* key : {kAccessKey, kSecretKey, kSessionToken}) {
    const char* const value = std::getenv(absl::AsciiStrToUpper(key).c_str());
    if (value != nullptr) values[key] = value;
  }
  return values;
}

Values OfText(absl::string_view text) {
  Values values;
  bool ours = true;
  for (absl::string_view line : absl::StrSplit(text, '\n')) {
    line = absl::StripAsciiWhitespace(line);
    if (absl::StartsWith(line, "#") || line.empty()) continue;
    if (absl::StartsWith(line, "[")) {
      ours = line == "[default]";
      continue;
    }
    const std::size_t equals = line.find('=');
    if (!ours || equals == absl::string_view::npos) continue;
    values[std::string(absl::StripAsciiWhitespace(line.substr(0, equals)))] =
        std::string(absl::StripAsciiWhitespace(line.substr(equals + 1)));
  }
  return values;
}

absl::StatusOr<Values> OfFile(const std::filesystem::path& file) {
  namespace fs = std::filesystem;
  const absl::StatusOr<std::string> text = ReadSmallFile(file);
  if (!text.ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat("object_credentials: ", text.status().message()));
  }
  std::error_code error;
  const fs::perms mode = fs::status(file, error).permissions();
  if (!error && (mode & fs::perms::others_all) != fs::perms::none) {
    return absl::InvalidArgumentError(
        absl::StrCat("object_credentials is ", Quoted(file.string()),
                     ", which everyone on the machine may use; its mode must be 0640 or less"));
  }
  return OfText(*text);
}

/// A value of a header must not begin another one.
bool IsPrintable(absl::string_view text) {
  for (const char c : text) {
    if (!absl::ascii_isgraph(static_cast<unsigned char>(c))) return false;
  }
  return true;
}

}  // namespace

absl::StatusOr<ObjectCredentials> ReadObjectCredentials(const std::filesystem::path& file) {
  const absl::StatusOr<Values> values = file.empty() ? OfEnvironment() : OfFile(file);
  if (!values.ok()) return values.status();
  const std::string where =
      file.empty() ? "object_credentials is empty, and in the environment "
                   : absl::StrCat("object_credentials is ", Quoted(file.string()), ", and in it ");
  for (const char* key : {kAccessKey, kSecretKey, kSessionToken}) {
    const auto value = values->find(key);
    const bool missing = value == values->end() || value->second.empty();
    if (missing && key == absl::string_view(kSessionToken)) continue;
    if (!missing && IsPrintable(value->second)) continue;
    return absl::InvalidArgumentError(
        absl::StrCat(where, file.empty() ? absl::AsciiStrToUpper(key) : key,
                     missing ? " is missing" : " has characters that are not printable"));
  }
  const auto token = values->find(kSessionToken);
  return ObjectCredentials{.access_key_id = values->find(kAccessKey)->second,
                           .secret_access_key = values->find(kSecretKey)->second,
                           .session_token = token == values->end() ? "" : token->second};
}

}  // namespace dcloc::server
