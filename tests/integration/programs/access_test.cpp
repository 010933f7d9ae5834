// Tests of the client's and the server's options for tokens and TLS.

#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "programs.h"
#include "tests/support/test_certificate.h"

namespace lode::test {
namespace {

using Json = nlohmann::json;

constexpr const char* kToken = "open-sesame";

/// A server with TLS that requires a token.
class Access : public testing::Test {
 protected:
  Access() {
    writeCertificate(folder_ / "other.crt", folder_ / "other.key");
    writeBytes(folder_ / "token", std::string(kToken) + "\n");
    writeBytes(folder_ / "wrong", "open-barley\n");
    for (const char* name : {"token", "wrong"})
      std::filesystem::permissions(folder_ / name, std::filesystem::perms(0600));
  }

  std::vector<std::string> with(std::vector<std::string> arguments, const std::string& token = "token",
                                const std::string& authorities = "a.crt") const {
    arguments.insert(arguments.end(), {"--ca-file", folder_ / authorities});
    if (!token.empty()) arguments.insert(arguments.end(), {"--token-file", folder_ / token});
    return arguments;
  }

  /// Writes the server's files. @return its arguments.
  std::vector<std::string> prepare() const {
    writeCertificate(folder_ / "a.crt", folder_ / "a.key");
    writeBytes(folder_ / "tokens", std::string(kToken) + " never *\n");
    std::filesystem::permissions(folder_ / "tokens", std::filesystem::perms(0600));
    return {"--token-file",    folder_ / "tokens", "--tls-cert",
            folder_ / "a.crt", "--tls-key",        folder_ / "a.key"};
  }

  const WorkFolder folder_;
  const RunningServer server_{{makeSmallStore(folder_)}, prepare()};
  const std::string server_url_ =
      "lodes://localhost" + server_.address().substr(server_.address().rfind(':'));
  const std::string model_url_ = server_url_ + "/small";
};

TEST_F(Access, isGrantedByATokenForEveryCommand) {
  const Outcome fetched = lodestream(with({"fetch", model_url_, "--json"}));
  EXPECT_EQ(fetched.status, 0) << fetched.err;
  EXPECT_EQ(Json::parse(fetched.out, nullptr, false).value("converged", false), true);
  const Outcome listed = lodestream(with({"list", server_url_, "--json"}));
  EXPECT_EQ(listed.status, 0) << listed.err;
  EXPECT_EQ(Json::parse(listed.out)["models"][0]["name"], "small");
  const Outcome loaded =
      lodestream(with({"loadtest", model_url_, "--clients", "3", "--seconds", "1", "--json"}));
  EXPECT_EQ(loaded.status, 0) << loaded.err;
  EXPECT_EQ(Json::parse(loaded.out)["errors"], 0);
}

TEST_F(Access, isGrantedByATokenInTheEnvironment) {
  const Outcome fetched =
      lodestream(with({"fetch", model_url_, "--json"}, ""), {std::string("LODESTREAM_TOKEN=") + kToken});
  EXPECT_EQ(fetched.status, 0) << fetched.err;
}

TEST_F(Access, isRefusedWithAdviceWithoutTheToken) {
  expectFailure(lodestream(with({"fetch", model_url_}, "")), {"requires a token", "--token-file"});
  expectFailure(lodestream(with({"list", server_url_}, "wrong")), {"is unknown", "--token-file"});
}

TEST_F(Access, isRefusedIfTheServersCertificateIsNotTrusted) {
  expectFailure(lodestream(with({"fetch", model_url_}, "token", "other.crt")),
                {"certificate is not trusted", "--ca-file"});
  const std::string by_number = "lodes://" + server_.address() + "/small";
  expectFailure(lodestream(with({"fetch", by_number})), {"mismatch", "--ca-file"});
}

TEST_F(Access, failsWithAdviceOverPlainTcpToATlsServer) {
  expectFailure(lodestream({"fetch", "lode" + model_url_.substr(5), "--token-file", folder_ / "token"}),
                {"lodes://"});
}

}  // namespace
}  // namespace lode::test
