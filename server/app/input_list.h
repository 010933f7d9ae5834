#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace lode::app {

constexpr size_t kMaxInputs = 65536;

/// Returns the input files that words of a command line name: a file by its path, all files *.ply of a folder
/// in the order of their names, and with `@LIST` the files that a text file names, one per line. Relative
/// paths of a list start at the working directory.
/// @throws Error kUsage if there are no files or more than kMaxInputs; kIo if a list or a folder cannot be
/// read.
std::vector<std::filesystem::path> listInputs(const std::vector<std::string>& words);

}  // namespace lode::app
