#include "client/stream/served_model.h"

#include "common/error.h"
#include "common/limits.h"

namespace lode::stream {
namespace {

constexpr std::string_view kScheme = "lode://", kTlsScheme = "lodes://";
constexpr const char* kServerForm = "write lode://HOST[:PORT], or lodes:// with TLS";
constexpr const char* kModelForm = "write lode://HOST[:PORT]/MODEL, or lodes:// with TLS";

struct Url {
  bool encrypted = false;
  std::string_view rest;
};

/// @param form  correct form of the URL, for the error message.
Url splitScheme(std::string_view text, const char* form) {
  for (const auto scheme : {kScheme, kTlsScheme})
    if (text.starts_with(scheme)) return {scheme == kTlsScheme, text.substr(scheme.size())};
  throw Error(ErrorCode::kUsage, "'" + std::string(text) + "' names no server; " + form);
}

}  // namespace

ServedModel parseServedModel(std::string_view text) {
  const auto [encrypted, rest] = splitScheme(text, kModelForm);
  const size_t slash = rest.find('/');
  if (slash == std::string_view::npos || slash + 1 == rest.size())
    throw Error(ErrorCode::kUsage, "'" + std::string(text) + "' names no model; " + kModelForm);
  std::string model(rest.substr(slash + 1));
  if (model.size() > kMaxModelNameBytes || model.find('/') != std::string::npos)
    throw Error(ErrorCode::kUsage, "'" + std::string(text) +
                                       "' is not a model's name: a name contains no slash and is at most " +
                                       std::to_string(kMaxModelNameBytes) + " bytes long");
  return {net::parseAddress(rest.substr(0, slash)), std::move(model), encrypted};
}

ServedModel parseServer(std::string_view text) {
  auto [encrypted, rest] = splitScheme(text, kServerForm);
  if (rest.ends_with('/')) rest.remove_suffix(1);
  if (rest.find('/') != std::string_view::npos)
    throw Error(ErrorCode::kUsage,
                "'" + std::string(text) + "' names a model, but a server is needed; " + kServerForm);
  return {net::parseAddress(rest), "", encrypted};
}

}  // namespace lode::stream
