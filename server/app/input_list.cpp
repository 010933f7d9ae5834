#include "server/app/input_list.h"

#include <algorithm>
#include <fstream>

#include "common/error.h"

namespace lode::app {
namespace {

constexpr size_t kMaxPathBytes = 1 << 16;

std::vector<std::filesystem::path> filesOfList(const std::string& path) {
  std::ifstream list(path);
  if (!list || std::filesystem::is_directory(path))
    throw Error(ErrorCode::kIo, "cannot read the list of inputs " + path + "; check the path after @");
  std::vector<std::filesystem::path> files;
  for (std::string line; std::getline(list, line);) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty()) continue;
    if (line.size() > kMaxPathBytes || files.size() == kMaxInputs)
      throw Error(ErrorCode::kUsage, path + ": is no list of at most " + std::to_string(kMaxInputs) +
                                         " files, one path per line");
    files.emplace_back(line);
  }
  return files;
}

std::vector<std::filesystem::path> filesOfFolder(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    std::error_code ignored;
    if (entry.path().extension() == ".ply" && !entry.is_directory(ignored)) files.push_back(entry.path());
  }
  if (error)
    throw Error(ErrorCode::kIo, "cannot list the folder " + folder.string() + ": " + error.message() +
                                    "; check its permissions");
  if (files.empty())
    throw Error(ErrorCode::kUsage, folder.string() + ": has no files *.ply; name another folder");
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

std::vector<std::filesystem::path> listInputs(const std::vector<std::string>& words) {
  std::vector<std::filesystem::path> inputs;
  for (const std::string& word : words) {
    std::error_code ignored;
    std::vector<std::filesystem::path> files{word};
    if (word.size() > 1 && word.front() == '@') {
      files = filesOfList(word.substr(1));
    } else if (std::filesystem::is_directory(word, ignored)) {
      files = filesOfFolder(word);
    }
    inputs.insert(inputs.end(), files.begin(), files.end());
  }
  if (inputs.empty()) throw Error(ErrorCode::kUsage, "the list names no input; write one path per line");
  if (inputs.size() > kMaxInputs)
    throw Error(ErrorCode::kUsage, std::to_string(inputs.size()) + " inputs; the limit is " +
                                       std::to_string(kMaxInputs) + "; merge some of them");
  return inputs;
}

}  // namespace lode::app
