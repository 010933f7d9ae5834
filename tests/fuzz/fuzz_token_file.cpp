// Parses any bytes as a token file. The parser must fail with an error of one line, or succeed.
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "common/error.h"
#include "server/serve/session/token_file.h"

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const auto file = lode::serve::TokenFile::parse(text);
    require(file.size() > 0 && file.size() <= lode::serve::kMaxTokens);
    require(file.find("", std::chrono::system_clock::time_point()) == nullptr);
  } catch (const lode::Error& error) {
    require(std::strpbrk(error.what(), "\r\n") == nullptr);
  }
  return 0;
}
