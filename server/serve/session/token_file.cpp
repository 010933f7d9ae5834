#include "server/serve/session/token_file.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <iomanip>
#include <iterator>
#include <set>
#include <span>
#include <sstream>

#include <openssl/crypto.h>

#include "common/error.h"
#include "common/limits.h"
#include "common/printable.h"
#include "proto/limits.h"

namespace lode::serve {

namespace {

/// Byte order mark of UTF-8, which some editors write at the start of a file.
constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

[[noreturn]] void refuse(size_t line, const std::string& what) {
  throw Error(ErrorCode::kUsage, "line " + std::to_string(line) + " of the token file: " + what +
                                     "; write TOKEN, then never or a time like 2027-01-31T12:00:00Z, then "
                                     "the models or *");
}

Digest hashOf(std::string_view token) { return digestOf(std::as_bytes(std::span(token))); }

/// Parses a time such as 2027-01-31T12:00:00Z. Returns nothing for other text.
std::optional<std::chrono::sys_seconds> parseTime(std::string_view text) {
  constexpr std::string_view kForm = "dddd-dd-ddTdd:dd:ddZ";
  if (text.size() != kForm.size()) return {};
  for (size_t i = 0; i < text.size(); ++i)
    if (kForm[i] == 'd' ? text[i] < '0' || text[i] > '9' : text[i] != kForm[i]) return {};
  const auto number = [text](size_t at, size_t digits) {
    int value = 0;
    std::from_chars(text.data() + at, text.data() + at + digits, value);
    return value;
  };
  using namespace std::chrono;
  const year_month_day date(year(number(0, 4)), month(static_cast<unsigned>(number(5, 2))),
                            day(static_cast<unsigned>(number(8, 2))));
  if (!date.ok() || number(11, 2) > 23 || number(14, 2) > 59 || number(17, 2) > 60) return {};
  return sys_days(date) + hours(number(11, 2)) + minutes(number(14, 2)) + seconds(number(17, 2));
}

/// Splits a line into words. Stops at a word that begins with #. A word in double quotes can contain spaces
/// and escaped quotes.
std::vector<std::string> wordsOf(const std::string& line, size_t number) {
  std::istringstream in(line);
  std::vector<std::string> words;
  while (in >> std::ws && !in.eof() && in.peek() != '#') {
    std::string word;
    const bool quoted = in.peek() == '"';
    in >> std::quoted(word);
    if (!in || (quoted && in.eof() && line.back() != '"')) refuse(number, "a quote is not closed");
    words.push_back(std::move(word));
  }
  return words;
}

TokenGrant parseGrant(std::span<const std::string> words, size_t line) {
  TokenGrant grant;
  if (words.size() < 2) refuse(line, "it names no model");
  if (words[0] != "never") {
    grant.expires = parseTime(words[0]);
    if (!grant.expires) refuse(line, "the second word is neither never nor a time");
  }
  grant.models.assign(words.begin() + 1, words.end());
  std::ranges::sort(grant.models);
  for (const std::string& name : grant.models)
    if (name.empty() || name.size() > kMaxModelNameBytes || !isPrintableUtf8(name))
      refuse(line, "a model name is invalid");
  if (std::ranges::find(grant.models, "*") == grant.models.end()) return grant;
  if (grant.models.size() > 1) refuse(line, "* allows all models and must be the only name");
  grant.all_models = true;
  grant.models.clear();
  return grant;
}

}  // namespace

bool TokenGrant::allows(std::string_view model) const noexcept {
  return all_models || std::binary_search(models.begin(), models.end(), model, std::less<>());
}

TokenFile TokenFile::parse(std::string_view text) {
  TokenFile file;
  std::vector<size_t> lines;
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  std::istringstream in{std::string(text)};
  std::string line;
  for (size_t number = 1; std::getline(in, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    const std::vector<std::string> words = wordsOf(line, number);
    if (words.empty()) continue;
    if (words[0].empty() || words[0].size() > proto::kMaxTokenBytes || !isPrintableUtf8(words[0]))
      refuse(number,
             "a token is 1 to " + std::to_string(proto::kMaxTokenBytes) + " bytes of printable UTF-8");
    Entry entry{hashOf(words[0]), parseGrant(std::span(words).subspan(1), number)};
    const auto same = std::ranges::find(file.entries_, entry.hash, &Entry::hash);
    if (same != file.entries_.end())
      refuse(number, "the token is also in line " + std::to_string(lines[same - file.entries_.begin()]));
    if (file.entries_.size() == kMaxTokens)
      throw Error(ErrorCode::kLimit, "line " + std::to_string(number) + " of the token file: more than " +
                                         std::to_string(kMaxTokens) + " tokens");
    file.entries_.push_back(std::move(entry));
    lines.push_back(number);
  }
  if (file.entries_.empty())
    throw Error(ErrorCode::kUsage, "the token file holds no token, so no client could connect");
  return file;
}

TokenFile TokenFile::read(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string text(kMaxTokenFileBytes + 1, '\0');
  if (in) in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!in.is_open() || in.bad())
    throw Error(ErrorCode::kIo, "cannot read the token file " + path.string() + ": " + std::strerror(errno) +
                                    "; check its name and permissions");
  text.resize(static_cast<size_t>(in.gcount()));
  if (text.size() > kMaxTokenFileBytes)
    throw Error(ErrorCode::kLimit, "the token file " + path.string() + " has more than " +
                                       std::to_string(kMaxTokenFileBytes) + " bytes");
  try {
    return parse(text);
  } catch (const Error& error) {
    throw Error(error.code(), path.string() + ": " + error.what());
  }
}

std::vector<std::string> TokenFile::modelsNamed() const {
  std::set<std::string> names;
  for (const Entry& entry : entries_) names.insert(entry.grant.models.begin(), entry.grant.models.end());
  return {names.begin(), names.end()};
}

bool TokenFile::allHaveExpired(std::chrono::system_clock::time_point now) const noexcept {
  return std::ranges::all_of(entries_, [now](const Entry& entry) { return entry.grant.hasExpired(now); });
}

const TokenGrant* TokenFile::find(std::string_view token, std::chrono::system_clock::time_point now) const {
  const Digest hash = hashOf(token);
  const TokenGrant* found = nullptr;
  for (const Entry& entry : entries_) {
    const bool same = CRYPTO_memcmp(entry.hash.bytes.data(), hash.bytes.data(), hash.bytes.size()) == 0;
    found = same ? &entry.grant : found;
  }
  if (found != nullptr && found->hasExpired(now)) return nullptr;
  return found;
}

}  // namespace lode::serve
