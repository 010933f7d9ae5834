#pragma once

#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/codec/model_summary.h"

namespace lode::app {

using Json = nlohmann::ordered_json;

/// Prints a JSON object as one line to stdout. @throws Error kIo if writing fails.
void printJson(const Json& object);

/// Prints text and flushes the stream. @throws Error kIo if writing fails.
void printText(const std::string& text, std::FILE* stream = stdout);

/// Converts a box to world coordinates: {"min":[x,y,z],"max":[x,y,z]}, or null if the box is empty.
Json toJson(const LatticeBox& box, const Lattice& lattice);

/// Returns the command-line names of the attributes: normal, color, alpha, uv, texnumber.
std::vector<std::string> attributeNames(AttributeSet attributes);

/// Converts the fields of a model that both `info` and `build` print.
Json toJson(const ModelSummary& summary);

/// Returns the length of the box's diagonal in model units.
double boxDiagonal(const ModelSummary& summary);

}  // namespace lode::app
