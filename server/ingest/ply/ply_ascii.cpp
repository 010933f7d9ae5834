#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>

#include <fast_float/fast_float.h>

#include "common/error.h"
#include "common/printable.h"
#include "server/ingest/ply/ply_body.h"

namespace lode::ingest {
namespace {

/// Maximum length of a number. The exact digits of a double can take 1079 characters, but no program writes
/// so many.
constexpr size_t kMaxTokenBytes = 512;

constexpr const char* kOneRowPerLine = ", with one row per line";

bool isBlank(char c) noexcept { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
bool isLineEnd(char c) noexcept { return c == '\n' || c == '\r'; }

enum class Parsed { kOk, kNoNumber, kNoInteger, kOutOfRange };

template <class T>
Parsed parseFloating(std::string_view token, double& value) {
  T parsed{};
  const char* const end = token.data() + token.size();
  const auto result = fast_float::from_chars(token.data(), end, parsed);
  value = static_cast<double>(parsed);
  // For a number out of range, all versions of fast_float return zero or infinity; newer versions also report
  // an error.
  const bool is_number = result.ec == std::errc{} || result.ec == std::errc::result_out_of_range;
  if (is_number && result.ptr == end) return Parsed::kOk;
  // The C library of Windows writes 1.#INF, -1.#IND and 1.#QNAN.
  if (token.find('#') != std::string_view::npos && result.ptr != token.data()) {
    value = std::numeric_limits<double>::quiet_NaN();
    return Parsed::kOk;
  }
  return Parsed::kNoNumber;
}

template <class T>
Parsed parseInteger(std::string_view token, double& value) {
  int64_t parsed = 0;
  const char* const end = token.data() + token.size();
  const auto result = std::from_chars(token.data(), end, parsed);
  value = static_cast<double>(parsed);
  if (result.ec == std::errc::result_out_of_range) return Parsed::kOutOfRange;
  if (result.ec != std::errc{} || result.ptr != end) {
    const Parsed as_double = parseFloating<double>(token, value);
    if (as_double != Parsed::kOk) return as_double;
    if (!(std::trunc(value) == value)) return Parsed::kNoInteger;
  }
  const bool fits = value >= static_cast<double>(std::numeric_limits<T>::min()) &&
                    value <= static_cast<double>(std::numeric_limits<T>::max());
  return fits ? Parsed::kOk : Parsed::kOutOfRange;
}

/// Parses a value of the given type. Parses a float directly, not through double, so that it is rounded only
/// once.
Parsed parseValue(PlyType type, std::string_view token, double& value) {
  if (token.starts_with('+')) token.remove_prefix(1);
  return withPlyType(type, [&]<class T>(std::type_identity<T>) {
    if constexpr (std::is_floating_point_v<T>) {
      return parseFloating<T>(token, value);
    } else {
      return parseInteger<T>(token, value);
    }
  });
}

class AsciiBody final : public PlyBody {
 public:
  AsciiBody(PlyInput& input, PlyReadOptions options, uint64_t first_line, uint64_t& extra_tokens)
      : PlyBody(input, options), line_(first_line), extra_tokens_(extra_tokens) {}

  void readVertices(const VertexPlan& plan, PlyVertexBatch& batch) override {
    element_ = plan.element;
    VertexValues values{};
    for (row_ = 0; row_ < element_->count; ++row_) {
      beginRow();
      for (size_t i = 0; i < plan.fields.size(); ++i) {
        const PlyProperty& property = element_->properties[i];
        if (plan.fields[i] == VertexField::kNone) {
          skipProperty(property);
        } else {
          values[static_cast<size_t>(plan.fields[i])] = takeValue(property.name, property.type);
        }
      }
      handleVertexDefect(makeVertex(plan, values, batch.room().front()), 0, batch);
      batch.commit(1);
      endRow();
    }
    batch.flush();
  }

  void readFaces(const FacePlan& plan, PlyFaceBatch& batch) override {
    element_ = plan.element;
    for (row_ = 0; row_ < element_->count; ++row_) {
      beginRow();
      if (plan.strips) {
        readStripRow(plan, batch);
      } else {
        readFaceRow(plan, batch);
      }
      endRow();
    }
    batch.flush();
  }

  void skip(const PlyElement& element) override {
    element_ = &element;
    for (row_ = 0; row_ < element.count; ++row_) {
      beginRow();
      for (const PlyProperty& property : element.properties) skipProperty(property);
      while (!nextToken().empty()) continue;
      endRow();
    }
  }

  PlyPlace place() const noexcept override { return {input_.offset(), line_}; }
  void goTo(PlyPlace place) override {
    input_.seek(place.offset);
    line_ = place.line;
  }

  uint64_t leastRowBytes(const PlyElement& element) const noexcept override {
    return 2 * element.properties.size();  // each property takes at least a digit and a separator
  }

 private:
  std::string where() const override { return "line " + std::to_string(line_); }

  bool skipBlanks() {
    for (;;) {
      const char* const data = input_.data();
      const size_t available = input_.available();
      size_t i = 0;
      while (i < available && isBlank(data[i])) ++i;
      input_.consume(i);
      if (i < available) return true;
      if (!input_.fill(1)) return false;
    }
  }

  /// Returns the next word of the line, valid until the next call. Returns an empty word at the end of the
  /// line.
  std::string_view nextToken() {
    if (!skipBlanks()) return {};
    if (input_.available() <= kMaxTokenBytes) {
      input_.fill(static_cast<size_t>(std::min<uint64_t>(input_.remaining(), kMaxTokenBytes + 1)));
    }
    const char* const data = input_.data();
    const size_t limit = std::min(input_.available(), kMaxTokenBytes + 1);
    size_t size = 0;
    while (size < limit && !isBlank(data[size]) && !isLineEnd(data[size])) ++size;
    if (size > kMaxTokenBytes) {
      fail("a word of more than " + std::to_string(kMaxTokenBytes) + " characters",
           "the file is damaged; export it again");
    }
    input_.consume(size);
    return {data, size};
  }

  void takeLineEnd() {
    const bool carriage_return = *input_.data() == '\r';
    input_.consume(1);
    if (carriage_return && input_.fill(1) && *input_.data() == '\n') input_.consume(1);
    ++line_;
  }

  /// Moves to the first word of the next non-empty line.
  void beginRow() {
    while (skipBlanks()) {
      if (!isLineEnd(*input_.data())) return;
      takeLineEnd();
    }
    failTruncated(kOneRowPerLine);
  }

  void endRow() {
    while (!nextToken().empty()) ++extra_tokens_;
    if (input_.available() > 0) takeLineEnd();
  }

  std::string_view takeToken(const std::string& property) {
    const std::string_view token = nextToken();
    if (token.empty()) {
      fail("the line is too short: a value of " + property + " is missing",
           std::string("complete the row or export the mesh again") + kOneRowPerLine);
    }
    return token;
  }

  double takeValue(const std::string& property, PlyType type) {
    const std::string_view token = takeToken(property);
    double value = 0;
    const Parsed parsed = parseValue(type, token, value);
    if (parsed != Parsed::kOk) failToken(property, type, token, parsed);
    return value;
  }

  [[noreturn]] void failToken(const std::string& property, PlyType type, std::string_view token,
                              Parsed parsed) const {
    const char* const what = parsed == Parsed::kNoNumber    ? " is not a number"
                             : parsed == Parsed::kNoInteger ? " is not a whole number"
                                                            : " is out of the range of ";
    fail(property + " " + quotedText(token) + what + (parsed == Parsed::kOutOfRange ? plyTypeName(type) : ""),
         "correct the value or the property's type");
  }

  uint64_t takeListCount(const PlyProperty& list) {
    const double count = takeValue(list.name, list.count_type);
    if (count < 0)
      fail("list " + list.name + " has a negative count", "correct the row or export the mesh again");
    return static_cast<uint64_t>(count);
  }

  void skipProperty(const PlyProperty& property) {
    const uint64_t values = property.is_list ? takeListCount(property) : 1;
    for (uint64_t i = 0; i < values; ++i) takeToken(property.name);
  }

  void readFaceRow(const FacePlan& plan, PlyFaceBatch& batch) {
    beginFace();
    for (size_t i = 0; i < plan.roles.size(); ++i) {
      const PlyProperty& property = element_->properties[i];
      const FaceRole role = plan.roles[i];
      if (role == FaceRole::kSkipped) {
        skipProperty(property);
      } else if (!property.is_list) {
        takeFaceValue(role, property.type, takeValue(property.name, property.type));
      } else {
        const uint64_t count = takeListCount(property);
        checkListLength(property, role, count);
        for (uint64_t item = 0; item < count; ++item) {
          const double value = takeValue(property.name, property.type);
          if (role == FaceRole::kIndices) {
            corners_.push_back(static_cast<int64_t>(value));
          } else {
            texture_.push_back(static_cast<float>(value));
          }
        }
      }
    }
    addFace(batch);
  }

  void readStripRow(const FacePlan& plan, PlyFaceBatch& batch) {
    for (size_t i = 0; i < plan.roles.size(); ++i) {
      const PlyProperty& property = element_->properties[i];
      if (plan.roles[i] != FaceRole::kIndices) {
        skipProperty(property);
        continue;
      }
      StripCutter strip(batch);
      const uint64_t count = takeListCount(property);
      for (uint64_t item = 0; item < count; ++item) {
        addStripIndex(static_cast<int64_t>(takeValue(property.name, property.type)), strip, batch);
      }
    }
  }

  uint64_t line_;
  uint64_t& extra_tokens_;
};

}  // namespace

std::unique_ptr<PlyBody> makeAsciiBody(PlyInput& input, PlyReadOptions options, uint64_t first_line,
                                       uint64_t& extra_tokens) {
  return std::make_unique<AsciiBody>(input, options, first_line, extra_tokens);
}

}  // namespace lode::ingest
