// Tests of the library for other programs: programs find the installed library, compile with it and run.

#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "programs.h"

namespace lode::test {
namespace {

namespace fs = std::filesystem;

/// An installed tree. The sources and the build from which it was installed are not accessible.
class Embedding : public testing::Test {
 protected:
  void SetUp() override {
#ifdef LODE_SANITIZED
    GTEST_SKIP() << "a program would have to be compiled with the same sanitizers";
#endif
    run("cmake", {"--install", LODE_BIN_DIR, "--component", "embed", "--prefix", installed_});
  }

  std::string run(const std::string& program, const std::vector<std::string>& arguments,
                  const std::vector<std::string>& environment = {}) const {
    const Outcome outcome = Program(program, arguments, environment).wait();
    EXPECT_EQ(outcome.status, 0) << program << ": " << outcome.out << outcome.err;
    return outcome.out;
  }

  fs::path library() const {
    for (const auto& entry : fs::recursive_directory_iterator(installed_))
      if (entry.path().filename() == "liblodestream.a") return entry.path();
    ADD_FAILURE() << "no library";
    return {};
  }
  fs::path examples() const { return installed_ / "share/doc/lodestream/examples"; }

  fs::path compileInC(const fs::path& source) const {
    const std::vector<std::string> paths{"PKG_CONFIG_PATH=" +
                                         (library().parent_path() / "pkgconfig").string()};
    const std::string flags = run("pkg-config", {"--cflags", "--libs", "lodestream"}, paths);
    const fs::path program = folder_ / source.stem().string();
    run("sh", {"-c", "cc -std=c99 -Wall -Wextra -Werror -pedantic -o " + program.string() + " " +
                         source.string() + " " + flags.substr(0, flags.find('\n'))});
    return program;
  }

  void expectWalk(const fs::path& program, const std::string& url) const {
    const std::string said = run(program, {url});
    EXPECT_NE(said.find(" triangles in "), std::string::npos) << said;
    EXPECT_NE(said.find(" bytes received"), std::string::npos) << said;
    EXPECT_EQ(said.find("damaged"), std::string::npos) << said;
  }

  const WorkFolder folder_;
  const fs::path installed_ = folder_ / "installed";
};

TEST_F(Embedding, buildsAndRunsTheExamplesWithFindPackage) {
  const fs::path build = folder_ / "build";
  run("cmake", {"-G", "Ninja", "-S", examples(), "-B", build, "-DCMAKE_PREFIX_PATH=" + installed_.string()});
  run("cmake", {"--build", build});
  const RunningServer server({makeSmallStore(folder_)});
  expectWalk(build / "embed", server.url("small"));
  expectWalk(build / "embed_c", server.url("small"));
}

/// Program that opens a stream with zeros as options. It succeeds if the stream converges.
constexpr const char* kZeroOptions = R"(
#include <lodestream.h>
#include <stdio.h>
#include <string.h>
int main(int count, char** arguments) {
  lodestream_options options;
  lodestream_status status;
  lodestream_view view = {{0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 45, 640, 480, 1};
  lodestream_stream* stream;
  memset(&options, 0, sizeof options);
  memset(&status, 0, sizeof status);
  if (count != 2 || (stream = lodestream_open(arguments[1], &options)) == NULL) return 1;
  while (!status.is_open && lodestream_step(stream, 1000, &status) && !status.has_ended) continue;
  if (!lodestream_set_view(stream, &view)) return 1;
  do {
    if (!lodestream_step(stream, 1000, &status)) return 1;
  } while (!status.is_settled && !status.has_ended);
  puts(status.is_converged && !status.is_limited ? "converged" : "coarse");
  lodestream_close(stream);
  return 0;
}
)";

TEST_F(Embedding, treatsZeroOptionsAsDefaults) {
  writeBytes(folder_ / "zeros.c", kZeroOptions);
  const fs::path program = compileInC(folder_ / "zeros.c");
  const RunningServer server({makeSmallStore(folder_)});
  EXPECT_EQ(run(program, {server.url("small")}), "converged\n");
}

/// Program that fails to open a stream without an address. Then it prints the last error while there is no
/// cut.
constexpr const char* kNothingYet = R"(
#include <lodestream.h>
#include <stdio.h>
int main(int count, char** arguments) {
  lodestream_stream* stream;
  if (count != 2 || lodestream_open(NULL, NULL) != NULL) return 1;
  if ((stream = lodestream_open(arguments[1], NULL)) == NULL) return 1;
  if (lodestream_take_cut(stream) != NULL) return 1;
  puts(lodestream_last_error());
  lodestream_close(stream);
  return 0;
}
)";

TEST_F(Embedding, reportsANullUrlAndReturnsNoCutBeforeTheFirst) {
  writeBytes(folder_ / "nothing.c", kNothingYet);
  const RunningServer server({makeSmallStore(folder_)});
  EXPECT_EQ(run(compileInC(folder_ / "nothing.c"), {server.url("small")}),
            "the url is NULL: pass lode://HOST[:PORT]/MODEL\n");
}

TEST_F(Embedding, namesItsVersionForThePreprocessor) {
  writeBytes(folder_ / "version.c",
             "#include <lodestream.h>\n#include <stdio.h>\n"
             "int main(void) { return printf(\"%d.%d.%d\\n\", LODESTREAM_VERSION_MAJOR, "
             "LODESTREAM_VERSION_MINOR, LODESTREAM_VERSION_PATCH) < 0; }\n");
  const std::string version = run(compileInC(folder_ / "version.c"), {});
  EXPECT_EQ("lodestream " + version, run("lodestream", {"--version"}));
}

TEST_F(Embedding, isFoundTwiceByOneProject) {
  writeBytes(folder_ / "CMakeLists.txt",
             "cmake_minimum_required(VERSION 3.25)\nproject(twice LANGUAGES CXX)\n"
             "find_package(lodestream REQUIRED)\nfind_package(lodestream REQUIRED)\n");
  run("cmake", {"-G", "Ninja", "-S", folder_.path(), "-B", folder_ / "build",
                "-DCMAKE_PREFIX_PATH=" + installed_.string()});
}

TEST_F(Embedding, buildsAndRunsTheExampleInCWithPkgConfig) {
  const fs::path program = compileInC(examples() / "embed.c");
  const RunningServer server({makeSmallStore(folder_)});
  expectWalk(program, server.url("small"));
  const Outcome nobody = Program(program, {server.url("nobody")}).wait();
  EXPECT_EQ(nobody.status, 1);
  EXPECT_NE(nobody.err.find("nobody"), std::string::npos) << nobody.err;
}

TEST_F(Embedding, installsOneSelfContainedHeaderAndExportsOnlyItsOwnSymbols) {
  std::vector<std::string> headers;
  for (const auto& entry : fs::recursive_directory_iterator(installed_ / "include"))
    if (entry.is_regular_file()) headers.push_back(entry.path().filename());
  EXPECT_EQ(headers, std::vector<std::string>{"lodestream.h"});
  const std::string header = (installed_ / "include/lodestream.h").string();
  run("cc", {"-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-x", "c", "-fsyntax-only", header});
  run("c++",
      {"-std=c++11", "-Wall", "-Wextra", "-Werror", "-pedantic", "-x", "c++", "-fsyntax-only", header});
  EXPECT_EQ(run("sh", {"-c", "nm --extern-only --defined-only " + library().string() +
                                 " | awk 'NF == 3 { print $3 }' | grep -v '^lodestream_' || true"}),
            "");
  const std::string count = run(
      "sh", {"-c", "nm --extern-only --defined-only " + library().string() + " | grep -c ' T lodestream_'"});
  EXPECT_LE(std::stoi(count), 20);
}

}  // namespace
}  // namespace lode::test
