#pragma once

#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "server/serve/ops/log_limit.h"

namespace lode::serve {

/// A figure or word beside a line's message.
struct LogField {
  std::string_view name;
  std::variant<uint64_t, double, std::string_view> value;
};

/// Longest line, its end included: what a pipe takes whole or not at all.
constexpr size_t kMaxLogLineBytes = 4096;

/// How a kind is called in the log: "connection", "refused" and so on.
std::string_view logKindName(LogKind kind) noexcept;

/// "2026-11-22T03:18:12.123Z refused: the message (name=value, ...)" or, as JSON, one object with the keys
/// time, kind, message and the fields' names. What is not printable becomes '?'; ends in a line end. Thread
/// safe.
std::string logLine(bool json, std::chrono::system_clock::time_point time, LogKind kind,
                    std::string_view message, std::span<const LogField> fields);

}  // namespace lode::serve
