#pragma once

#include <string>

#include "common/error.h"

namespace lode::app {

/// Returns the words for a remedy, which name options of the command line. Returns an empty text for kNone.
const char* wordsFor(Remedy remedy) noexcept;

/// Returns a message as users see it: followed by "; " and the words for its remedy, if there is one.
std::string withRemedy(const std::string& message, Remedy remedy);

/// Returns the message of an error as users see it: see withRemedy().
std::string messageOf(const Error& error);

}  // namespace lode::app
