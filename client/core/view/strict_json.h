#pragma once

#include <algorithm>
#include <cstddef>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace lode::core {

/// Returns the place of an error, such as " at line 3, column 7". @param bytes  length of the text up to and
/// including the character at fault.
inline std::string placeIn(std::string_view text, size_t bytes) {
  const std::string_view before = text.substr(0, bytes > 0 ? bytes - 1 : 0);
  const auto line = 1 + std::ranges::count(before, '\n');
  const size_t column = before.size() - (before.rfind('\n') + 1);  // npos + 1 is 0
  return " at line " + std::to_string(line) + ", column " + std::to_string(column + 1);
}

/// Parses JSON written by people. Rejects an object that contains a name twice, because all but one of the
/// values would be ignored silently. @param problem  receives the error message; unchanged on success.
template <typename Json>
Json parseStrictly(std::string_view text, std::string& problem) {
  std::vector<std::set<std::string>> names;  // names seen so far, one set per enclosing object
  const auto checkNames = [&](int /*depth*/, typename Json::parse_event_t event, Json& parsed) {
    using Event = typename Json::parse_event_t;
    if (event == Event::object_start) names.emplace_back();
    if (event == Event::object_end) names.pop_back();
    if (event == Event::key && !names.back().insert(parsed.template get_ref<const std::string&>()).second)
      problem = parsed.dump(-1, ' ', true) + " appears twice";
    return true;
  };
  try {
    return Json::parse(text, checkNames);
  } catch (const typename Json::parse_error& error) {
    problem = "not JSON" + placeIn(text, error.byte);
  } catch (const typename Json::out_of_range&) {
    problem = "a number is too large";
  }
  return {};
}

}  // namespace lode::core
