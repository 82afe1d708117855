#include "server/tickets/ticket_keys.h"

#include <algorithm>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "server/base/small_file.h"
#include "server/base/status.h"

namespace dcloc::server {
namespace {

constexpr std::size_t kMaxIdSize = 16;

bool IsId(absl::string_view text) {
  return !text.empty() && text.size() <= kMaxIdSize && std::ranges::all_of(text, [](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '_' || c == '-';
  });
}

absl::StatusOr<TicketKey> ParseKey(absl::string_view line) {
  const std::vector<absl::string_view> words =
      absl::StrSplit(line, absl::ByAnyChar(" \t"), absl::SkipEmpty());
  if (words.size() != 2 || !IsId(words[0])) {
    return absl::InvalidArgumentError(absl::StrCat("it must be \"ID SECRET\", the id 1 to ",
                                                   kMaxIdSize, " of A-Z, a-z, 0-9, '.', '_', '-'"));
  }
  TicketKey key{.id = std::string(words[0])};
  const auto is_hex = [](char c) { return absl::ascii_isxdigit(static_cast<unsigned char>(c)); };
  if (words[1].size() != 2 * key.secret.size() || !std::ranges::all_of(words[1], is_hex)) {
    return absl::InvalidArgumentError(absl::StrCat("the secret of key ", key.id, " has ",
                                                   words[1].size(), " characters; it must be ",
                                                   2 * key.secret.size(), " hexadecimal digits"));
  }
  const std::string secret = absl::HexStringToBytes(words[1]);
  std::ranges::copy(secret, key.secret.begin());
  return key;
}

}  // namespace

absl::StatusOr<std::vector<TicketKey>> ParseTicketKeys(absl::string_view text) {
  std::vector<TicketKey> keys;
  int number = 0;
  for (absl::string_view line : absl::StrSplit(text, '\n')) {
    ++number;
    line = absl::StripAsciiWhitespace(line);
    if (line.empty() || line.front() == '#') continue;
    absl::StatusOr<TicketKey> key = ParseKey(line);
    if (!key.ok()) return WithPrefix(absl::StrCat("line ", number, ": "), key.status());
    if (std::ranges::find(keys, key->id, &TicketKey::id) != keys.end()) {
      return absl::InvalidArgumentError(
          absl::StrCat("line ", number, ": key ", key->id, " is there twice"));
    }
    keys.push_back(*std::move(key));
  }
  if (keys.empty() || keys.size() > kMaxTicketKeys) {
    return absl::InvalidArgumentError(
        absl::StrCat("there are ", keys.size(), " keys; there must be 1 to ", kMaxTicketKeys));
  }
  return keys;
}

absl::StatusOr<std::vector<TicketKey>> ReadTicketKeys(const std::filesystem::path& file) {
  namespace fs = std::filesystem;
  const absl::StatusOr<std::string> text = ReadSmallFile(file);
  if (!text.ok()) {
    return absl::InvalidArgumentError(absl::StrCat("ticket_keys: ", text.status().message()));
  }
  const std::string where = absl::StrCat("ticket_keys is ", Quoted(file.string()));
  std::error_code error;
  const fs::perms mode = fs::status(file, error).permissions();
  if (!error && (mode & fs::perms::others_all) != fs::perms::none) {
    return absl::InvalidArgumentError(absl::StrCat(
        where, ", which everyone on the machine may use; its mode must be 0600 (or 0640)"));
  }
  absl::StatusOr<std::vector<TicketKey>> keys = ParseTicketKeys(*text);
  if (!keys.ok()) return WithPrefix(absl::StrCat(where, ", and in it "), keys.status());
  return keys;
}

}  // namespace dcloc::server
