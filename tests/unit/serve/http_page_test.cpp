#include <array>
#include <fstream>
#include <map>
#include <string>

#include <asio/read.hpp>
#include <nlohmann/json.hpp>

#include "server/page/page_files.h"
#include "tests/support/bytes.h"
#include "tests/unit/serve/server_fixture.h"

namespace lode::serve::test {
namespace {

using Json = nlohmann::json;

const std::string kIndex = "<!doctype html>\n<script src=\"app/app.js\"></script>\n";
const std::string kScript(4000, ';');
const std::string kWasm("\0asm\1\0\0\0", 8);

struct Response {
  int status = 0;
  std::map<std::string, std::string> fields;  ///< header fields by name, in the case in which they were sent
  std::string body;
};

/// A server with a small page in place of the program's own.
class HttpPage : public ServerTest {
 protected:
  HttpPage() {
    options_.http = "127.0.0.1:0";
    options_.page = page_;
  }

  void requireTokens() {
    options_.token_file = folder_.path() / "tokens";
    std::ofstream(options_.token_file) << "right never a\n";
    std::filesystem::permissions(options_.token_file, std::filesystem::perms(0600));
  }

  /// Sends a request on a connection of its own and reads the response to its end.
  Response ask(const std::string& path, const std::string& fields = "Host: localhost\r\n",
               const std::string& method = "GET") {
    const std::string address = server_->httpAddress().value();
    const auto port = static_cast<uint16_t>(std::stoul(address.substr(address.rfind(':') + 1)));
    asio::io_context context;
    asio::ip::tcp::socket socket(context);
    socket.connect({asio::ip::address_v4::loopback(), port});
    asio::write(socket,
                asio::buffer(method + " " + path + " HTTP/1.1\r\n" + fields + "Connection: close\r\n\r\n"));
    std::string text;
    asio::error_code end;
    asio::read(socket, asio::dynamic_buffer(text), end);
    return parse(text);
  }

  static Response parse(const std::string& text) {
    Response response;
    const size_t end = text.find("\r\n\r\n");
    if (end == text.npos) {
      ADD_FAILURE() << "no response: " << text;
      return response;
    }
    response.status = std::stoi(text.substr(9));
    response.body = text.substr(end + 4);
    for (size_t at = text.find("\r\n"); at < end;) {
      const size_t next = text.find("\r\n", at + 2), colon = text.find(": ", at);
      response.fields[text.substr(at + 2, colon - at - 2)] = text.substr(colon + 2, next - colon - 2);
      at = next;
    }
    return response;
  }

 private:
  const std::array<page::PageFile, 3> page_{{{"index.html", lode::test::bytesOf(kIndex), "0123"},
                                             {"app.js", lode::test::bytesOf(kScript), "4567"},
                                             {"core.wasm", lode::test::bytesOf(kWasm), "89ab"}}};
};

TEST_F(HttpPage, isServedAtTheRootWithItsFilesBesideIt) {
  start();
  const Response index = ask("/");
  EXPECT_EQ(index.status, 200);
  EXPECT_EQ(index.body, kIndex);
  EXPECT_EQ(index.fields.at("Content-Type"), "text/html; charset=utf-8");
  const Response script = ask("/app.js");
  EXPECT_EQ(script.body, kScript);
  EXPECT_EQ(script.fields.at("Content-Type"), "text/javascript; charset=utf-8");
  const Response wasm = ask("/core.wasm");
  EXPECT_EQ(wasm.body, kWasm);
  EXPECT_EQ(wasm.fields.at("Content-Type"), "application/wasm");
  EXPECT_EQ(ask("/other.js").status, 404);
}

TEST_F(HttpPage, isSentAgainOnlyIfItChanged) {
  start();
  for (const auto& [path, tag] : {std::pair("/", "\"0123\""), std::pair("/app.js", "\"4567\"")}) {
    const Response response = ask(path);
    EXPECT_EQ(response.fields.at("ETag"), tag);
    EXPECT_EQ(response.fields.at("Cache-Control"), "no-cache");
    const Response again = ask(path, std::string("Host: localhost\r\nIf-None-Match: ") + tag + "\r\n");
    EXPECT_EQ(again.status, 304);
    EXPECT_EQ(again.body, "");
  }
}

TEST_F(HttpPage, isCompressedForThoseWhoAcceptIt) {
  start();
  const Response script = ask("/app.js", "Host: localhost\r\nAccept-Encoding: gzip, deflate, br\r\n");
  EXPECT_EQ(script.fields.at("Content-Encoding"), "gzip");
  EXPECT_EQ(script.fields.at("ETag"), "\"4567-gzip\"");
  EXPECT_EQ(script.body.substr(0, 2), "\x1f\x8b");
  EXPECT_LT(script.body.size(), 100u);
}

TEST_F(HttpPage, hasHeads) {
  start();
  const Response head = ask("/app.js", "Host: localhost\r\n", "HEAD");
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.body, "");
  EXPECT_EQ(head.fields.at("Content-Length"), std::to_string(kScript.size()));
}

TEST_F(HttpPage, needsNoTokenAndTellsNothingOfOne) {
  requireTokens();
  start();
  for (const std::string prefix : {"", "/t/right", "/t/wrong"}) {
    EXPECT_EQ(ask(prefix + "/").body, kIndex) << prefix;
    const Response script = ask(prefix + "/app.js");
    EXPECT_EQ(script.body, kScript) << prefix;
    EXPECT_EQ(script.fields.at("Cache-Control"), "no-cache") << prefix;
  }
  EXPECT_EQ(ask("/models.json").status, 401);
  EXPECT_EQ(ask("/t/wrong/models.json").status, 401);
  EXPECT_EQ(ask("/t/right/models.json").status, 200);
}

TEST_F(HttpPage, givesWayToAListOfTheModelsIfTheProgramHasNone) {
  options_.page = {};
  start();
  EXPECT_NE(ask("/").body.find("<a href=\"a/tileset.json\">"), std::string::npos);
  EXPECT_EQ(ask("/app.js").status, 404);
}

TEST_F(HttpPage, whoseListNamesModelsNeedsAToken) {
  options_.page = {};
  requireTokens();
  start();
  EXPECT_EQ(ask("/").status, 401);
  EXPECT_EQ(ask("/t/right/").body.find("\"b/tileset.json\""), std::string::npos);
  EXPECT_NE(ask("/t/right/").body.find("\"a/tileset.json\""), std::string::npos);
}

TEST_F(HttpPage, mayRunItsOwnScriptsOnly) {
  start();
  EXPECT_EQ(ask("/").fields.at("Content-Security-Policy"),
            "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; img-src 'self' "
            "blob: data:; "
            "connect-src 'self'; worker-src 'self'; base-uri 'none'; form-action 'none'");
}

TEST_F(HttpPage, isNotForPagesWhoseNameLeadsToThisMachine) {
  start();
  for (const std::string path : {"/", "/models.json", "/a/tileset.json", "/ws", "/nothing"})
    for (const std::string method : {"GET", "OPTIONS"}) {
      const Response response =
          ask(path, "Host: evil.example:80\r\nOrigin: http://evil.example:80\r\n", method);
      EXPECT_EQ(response.status, 421) << method << ' ' << path;
      EXPECT_EQ(response.body.find("\"models\""), std::string::npos);
    }
  EXPECT_NE(ask("/", "Host: a\r\n").body.find("--public"), std::string::npos);
  for (const char* const host : {"localhost:1", "127.0.0.1", "[::1]:7480"})
    EXPECT_EQ(ask("/", std::string("Host: ") + host + "\r\n").status, 200) << host;
}

TEST_F(HttpPage, isForAllNamesOfAPublicServer) {
  options_.public_ok = true;
  start();
  EXPECT_EQ(ask("/models.json", "Host: models.example\r\n").status, 200);
}

TEST_F(HttpPage, isForAllNamesOfAServerWithTokens) {
  requireTokens();
  start();
  EXPECT_EQ(ask("/", "Host: models.example\r\n").status, 200);
  EXPECT_EQ(ask("/t/right/models.json", "Host: models.example\r\n").status, 200);
}

TEST_F(HttpPage, hasALinkForThisMachineIfTheServerListensOnAllAddresses) {
  options_.public_ok = options_.insecure = true;
  options_.http = "0.0.0.0:0";
  start();
  const std::string address = server_->httpAddress().value();
  EXPECT_EQ(server_->pageLink(), "http://localhost" + address.substr(address.rfind(':')) + "/");
}

TEST_F(HttpPage, learnsANativePortThatItsHostReaches) {
  options_.public_ok = true;
  start();
  const auto nativeFor = [this](const std::string& host) {
    return Json::parse(ask("/models.json", "Host: " + host + "\r\n").body).at("native");
  };
  EXPECT_EQ(nativeFor("localhost:80"), (Json{{"port", server_->port()}, {"tls", false}}));
  EXPECT_TRUE(nativeFor("models.example").is_null()) << "the native port listens on loopback";
}

TEST_F(HttpPage, learnsANativePortThatOtherMachinesReach) {
  options_.public_ok = options_.insecure = true;
  options_.listen = "0.0.0.0:0";
  start();
  EXPECT_EQ(Json::parse(ask("/models.json", "Host: models.example\r\n").body).at("native").at("port"),
            server_->port());
}

}  // namespace
}  // namespace lode::serve::test
