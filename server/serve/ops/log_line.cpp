#include "server/serve/ops/log_line.h"

#include <array>
#include <cstdio>
#include <ctime>

#include <nlohmann/json.hpp>

#include "common/printable.h"

namespace lode::serve {

namespace {

constexpr size_t kMaxShownBytes = 1024;  ///< of the message and of a field: what people can read

std::string toIso(std::chrono::system_clock::time_point time) {
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(time.time_since_epoch()).count();
  const std::time_t seconds = ms / 1000;
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  std::array<char, 32> text{};
  const size_t length = std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%S", &parts);
  std::snprintf(text.data() + length, text.size() - length, ".%03dZ", static_cast<int>(ms % 1000));
  return text.data();
}

/// What others sent may end up here: nothing that moves a terminal's cursor, no second line.
std::string printable(std::string_view text) {
  std::string shown(text.substr(0, kMaxShownBytes));
  if (isPrintableUtf8(shown)) return shown;
  for (char& c : shown)
    if (c < 0x20 || c > 0x7E) c = '?';
  return shown;
}

std::string asText(const LogField& field) {
  if (const auto* count = std::get_if<uint64_t>(&field.value)) return std::to_string(*count);
  if (const auto* text = std::get_if<std::string_view>(&field.value)) return printable(*text);
  std::array<char, 32> number{};
  std::snprintf(number.data(), number.size(), "%.6g", std::get<double>(field.value));
  return number.data();
}

nlohmann::ordered_json asJson(const LogField& field) {
  if (const auto* count = std::get_if<uint64_t>(&field.value)) return *count;
  if (const auto* text = std::get_if<std::string_view>(&field.value)) return printable(*text);
  return std::get<double>(field.value);
}

std::string jsonLine(const std::string& time, LogKind kind, std::string_view message,
                     std::span<const LogField> fields) {
  nlohmann::ordered_json json;
  json["time"] = time;
  json["kind"] = logKindName(kind);
  json["message"] = printable(message);
  for (const LogField& field : fields) json[std::string(field.name)] = asJson(field);
  return json.dump();
}

std::string textLine(const std::string& time, LogKind kind, std::string_view message,
                     std::span<const LogField> fields) {
  std::string line = time + ' ' + std::string(logKindName(kind)) + ": " + printable(message);
  std::string_view before = " (";
  for (const LogField& field : fields) {
    line += std::string(before) + std::string(field.name) + '=' + asText(field);
    before = ", ";
  }
  if (!fields.empty()) line += ')';
  return line;
}

}  // namespace

std::string_view logKindName(LogKind kind) noexcept {
  constexpr std::array<std::string_view, kLogKinds> kNames{"server",  "connection", "refused", "unauthorized",
                                                           "mistake", "damage",     "system"};
  return kNames[static_cast<size_t>(kind)];
}

std::string logLine(bool json, std::chrono::system_clock::time_point time, LogKind kind,
                    std::string_view message, std::span<const LogField> fields) {
  const auto render = json ? jsonLine : textLine;
  std::string line = render(toIso(time), kind, message, fields);
  if (line.size() >= kMaxLogLineBytes) line = render(toIso(time), kind, message, {});
  return line += '\n';
}

}  // namespace lode::serve
