#include "server/ingest/ply/ply_header.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <string_view>
#include <utility>

#include "common/error.h"
#include "common/io/foreign_file.h"
#include "common/printable.h"
#include "server/ingest/ply/ply_input.h"

namespace lode::ingest {
namespace {

constexpr std::string_view kBlanks = " \t\v\f";

std::string_view trimmed(std::string_view text) {
  const size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

/// Removes the first word from a line and returns it.
std::string_view takeWord(std::string_view& line) {
  line = trimmed(line);
  const std::string_view word = line.substr(0, line.find_first_of(kBlanks));
  line = trimmed(line.substr(word.size()));
  return word;
}

std::optional<PlyType> typeOf(std::string_view name) {
  static constexpr std::array<std::pair<std::string_view, PlyType>, 16> kNames{{
      {"char", PlyType::kInt8},
      {"int8", PlyType::kInt8},
      {"uchar", PlyType::kUint8},
      {"uint8", PlyType::kUint8},
      {"short", PlyType::kInt16},
      {"int16", PlyType::kInt16},
      {"ushort", PlyType::kUint16},
      {"uint16", PlyType::kUint16},
      {"int", PlyType::kInt32},
      {"int32", PlyType::kInt32},
      {"uint", PlyType::kUint32},
      {"uint32", PlyType::kUint32},
      {"float", PlyType::kFloat32},
      {"float32", PlyType::kFloat32},
      {"double", PlyType::kFloat64},
      {"float64", PlyType::kFloat64},
  }};
  const auto* found =
      std::find_if(kNames.begin(), kNames.end(), [&](const auto& entry) { return entry.first == name; });
  if (found == kNames.end()) return std::nullopt;
  return found->second;
}

/// Splits a header into lines; see readPlyHeader() for line ends.
class HeaderLines {
 public:
  HeaderLines(std::string_view text, bool whole_file) : text_(text), whole_file_(whole_file) {}

  uint64_t number() const noexcept { return number_; }  ///< number of the line last returned, from 1
  size_t position() const noexcept { return position_; }

  /// Returns true if kMaxPlyHeaderBytes cuts off the line last returned or its line end.
  bool isCut() const noexcept { return !whole_file_ && is_last_; }

  std::optional<std::string_view> next() {
    if (position_ >= text_.size()) return std::nullopt;
    const size_t end = std::min(text_.find_first_of("\r\n", position_), text_.size());
    const std::string_view line = trimmed(text_.substr(position_, end - position_));
    position_ = end;
    ++number_;
    is_last_ = end == text_.size() || (text_[end] == '\r' && end + 1 == text_.size());
    if (end == text_.size()) return line;
    const bool carriage_return = text_[end] == '\r';
    const bool line_feed_follows = end + 1 < text_.size() && text_[end + 1] == '\n';
    const bool line_feed_is_body = line == "end_header" && number_ > 1 && only_carriage_returns_;
    const bool two_bytes = carriage_return && line_feed_follows && !line_feed_is_body;
    position_ += two_bytes ? 2 : 1;
    only_carriage_returns_ = only_carriage_returns_ && carriage_return && !two_bytes;
    return line;
  }

 private:
  std::string_view text_;
  bool whole_file_;
  size_t position_ = 0;
  uint64_t number_ = 0;
  bool only_carriage_returns_ = true;
  bool is_last_ = false;  ///< the line last returned, or its line end, reaches the end of the text
};

class HeaderParser {
 public:
  /// @param file  name of the file for messages.
  HeaderParser(const std::filesystem::path& path, std::string file, std::string_view text, bool whole_file)
      : path_(path), file_(std::move(file)), text_(text), whole_file_(whole_file), lines_(text, whole_file) {}

  PlyHeader parse() {
    checkMagic();
    for (;;) {
      const std::optional<std::string_view> line = lines_.next();
      if (!line || lines_.isCut()) failUnterminated();
      if (*line == "end_header") break;
      readLine(*line);
    }
    if (!has_format_) fail("there is no 'format' line", "export the mesh again");
    for (const PlyElement& element : header_.elements) {
      if (element.count > 0 && element.properties.empty()) {
        fail("element " + quotedText(element.name) + " has rows but no properties",
             "remove it from the header");
      }
    }
    header_.body_offset = lines_.position();
    header_.header_lines = lines_.number();
    return std::move(header_);
  }

 private:
  [[noreturn]] void fail(const std::string& what, const std::string& remedy) const {
    throw Error(ErrorCode::kInput,
                file_ + ", line " + std::to_string(lines_.number()) + ": " + what + "; " + remedy);
  }

  [[noreturn]] void failUnterminated() const {
    if (!whole_file_) {
      fail("the header has no end_header within " + std::to_string(kMaxPlyHeaderBytes) +
               " bytes, the limit of a header",
           "shorten its comments, or check that this is a PLY file");
    }
    fail("the file ends inside the header, without end_header", "copy or export the file again");
  }

  void checkMagic() {
    if (text_.starts_with("LODE\r\n")) {
      throw Error(ErrorCode::kInput,
                  file_ + " is a store, not a PLY file; convert it with lodestreamd export");
    }
    if (const auto foreign = foreignFileInWords(path_, text_))
      throw Error(ErrorCode::kInput, file_ + " " + *foreign);
    if (text_.starts_with("\xef\xbb\xbf")) {
      throw Error(ErrorCode::kInput,
                  file_ + " begins with a byte-order mark; save it as UTF-8 " + "without one");
    }
    if (lines_.next() != "ply") {
      throw Error(ErrorCode::kInput, file_ + " is not a PLY file: it begins with " + quotedText(text_, 16) +
                                         " instead of 'ply'; convert the mesh to PLY");
    }
  }

  void readLine(std::string_view line) {
    std::string_view rest = line;
    const std::string_view keyword = takeWord(rest);
    if (keyword.empty()) return;
    if (keyword == "comment" || keyword == "obj_info") return readComment(rest);
    if (keyword == "format") return readFormat(rest);
    if (keyword == "element") return readElement(rest);
    if (keyword == "property") return readProperty(rest);
    fail("unknown keyword " + quotedText(line), "remove the line or export the mesh again");
  }

  void readComment(std::string_view text) {
    header_.comments.emplace_back(text);
    if (takeWord(text) == "TextureFile" && !text.empty()) header_.texture_files.emplace_back(text);
  }

  void readFormat(std::string_view rest) {
    const std::string_view name = takeWord(rest);
    if (has_format_) fail("a second 'format' line", "remove one of them");
    if (name == "ascii") {
      header_.encoding = PlyEncoding::kAscii;
    } else if (name == "binary_little_endian") {
      header_.encoding = PlyEncoding::kLittleEndian;
    } else if (name == "binary_big_endian") {
      header_.encoding = PlyEncoding::kBigEndian;
    } else {
      fail("unknown format " + quotedText(name), "use ascii, binary_little_endian or binary_big_endian");
    }
    if (rest != "1.0")
      fail("unknown format version " + quotedText(rest), "only 1.0 exists: export the mesh again");
    has_format_ = true;
  }

  void readElement(std::string_view rest) {
    const std::string_view name = takeWord(rest);
    const std::string_view count_text = takeWord(rest);
    uint64_t count = 0;
    const char* const end = count_text.data() + count_text.size();
    const auto parsed = std::from_chars(count_text.data(), end, count);
    if (name.empty() || parsed.ec != std::errc{} || parsed.ptr != end || !rest.empty()) {
      fail("an element needs a name and a count, not " + quotedText(count_text), "write: element NAME COUNT");
    }
    if (header_.find(name) != nullptr)
      fail("a second element " + quotedText(name), "merge the two or rename one");
    if (header_.elements.size() >= kMaxPlyElements) {
      fail("more than " + std::to_string(kMaxPlyElements) + " elements", "remove those without geometry");
    }
    header_.elements.push_back({std::string(name), count, {}});
  }

  PlyType readType(std::string_view& rest) const {
    const std::string_view name = takeWord(rest);
    const std::optional<PlyType> type = typeOf(name);
    if (!type)
      fail("unknown type " + quotedText(name), "use char, uchar, short, ushort, int, uint, float or double");
    return *type;
  }

  void readProperty(std::string_view rest) {
    if (header_.elements.empty()) fail("a property before any element", "put an 'element' line before it");
    PlyElement& element = header_.elements.back();
    if (element.properties.size() >= kMaxPlyProperties) {
      fail("element " + quotedText(element.name) + " has more than " + std::to_string(kMaxPlyProperties) +
               " properties",
           "remove unneeded ones");
    }
    PlyProperty property;
    std::string_view peeked = rest;
    if (takeWord(peeked) == "list") {
      rest = peeked;
      property.is_list = true;
      property.count_type = readType(rest);
      if (isFloating(property.count_type))
        fail("a list counts in a floating type", "use uchar or int for the count");
    }
    property.type = readType(rest);
    property.name = takeWord(rest);
    if (property.name.empty() || !rest.empty()) {
      fail("a property needs one name", "write: property TYPE NAME, or property list COUNT_TYPE TYPE NAME");
    }
    element.properties.push_back(std::move(property));
  }

  std::filesystem::path path_;
  std::string file_;
  std::string_view text_;
  bool whole_file_;
  HeaderLines lines_;
  PlyHeader header_;
  bool has_format_ = false;
};

/// Replaces "<this>", which some writers use for the PLY file's name without extension.
void putStem(std::string& texture_file, const std::string& stem) {
  constexpr std::string_view kThis = "<this>";
  const size_t at = texture_file.find(kThis);
  if (at != std::string::npos) texture_file.replace(at, kThis.size(), stem);
}

}  // namespace

size_t plyTypeBytes(PlyType type) noexcept {
  static constexpr std::array<uint8_t, 8> kBytes{1, 1, 2, 2, 4, 4, 4, 8};
  return kBytes[static_cast<size_t>(type)];
}

bool isFloating(PlyType type) noexcept { return type >= PlyType::kFloat32; }

const char* plyTypeName(PlyType type) noexcept {
  static constexpr std::array<const char*, 8> kNames{"char", "uchar", "short", "ushort",
                                                     "int",  "uint",  "float", "double"};
  return kNames[static_cast<size_t>(type)];
}

const PlyElement* PlyHeader::find(std::string_view name) const noexcept {
  const auto found =
      std::find_if(elements.begin(), elements.end(), [&](const PlyElement& e) { return e.name == name; });
  return found == elements.end() ? nullptr : &*found;
}

PlyHeader readPlyHeader(const std::filesystem::path& path) {
  PlyInput input(path);
  const size_t bytes = static_cast<size_t>(std::min<uint64_t>(input.size(), kMaxPlyHeaderBytes));
  input.fill(bytes);
  const std::string_view text(input.data(), bytes);
  PlyHeader header = HeaderParser(path, input.name(), text, bytes == input.size()).parse();
  for (std::string& name : header.texture_files) putStem(name, path.stem().string());
  return header;
}

}  // namespace lode::ingest
