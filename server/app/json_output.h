#pragma once

#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/codec/model_summary.h"

namespace lode::app {

using Json = nlohmann::ordered_json;

/// Prints one JSON object as one line on stdout. @throws Error kIo if stdout takes no more.
void printJson(const Json& object);

/// @throws Error kIo if the stream takes no more.
void printText(const std::string& text, std::FILE* stream = stdout);

/// A box in true coordinates: {"min":[x,y,z],"max":[x,y,z]}, or null if it is empty.
Json toJson(const LatticeBox& box, const Lattice& lattice);

/// The attributes as the command line names them: normal, color, alpha, uv, texnumber.
std::vector<std::string> attributeNames(AttributeSet attributes);

/// What `info` and `build` both say of a model.
Json toJson(const ModelSummary& summary);

/// The length of the box's diagonal, in model units.
double boxDiagonal(const ModelSummary& summary);

}  // namespace lode::app
