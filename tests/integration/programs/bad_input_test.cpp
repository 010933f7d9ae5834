// Tests of bad input. Commands fail with one line that names the file, and leave no file behind.

#include <cmath>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "programs.h"

namespace lode::test {
namespace {

struct BadPly {
  const char* what;
  std::string bytes;
  std::vector<std::string> named;  ///< texts that the message must contain, besides the file's name
};

/// Returns the header of a file with three float vertices and one triangle. @param format format with its
/// version.
std::string header(const std::string& format, int faces = 1) {
  return "ply\nformat " + format +
         "\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face " +
         std::to_string(faces) + "\nproperty list uchar int vertex_indices\nend_header\n";
}

std::string littleEndian(const std::vector<float>& coordinates, const std::vector<int32_t>& corners) {
  std::string bytes = header("binary_little_endian 1.0");
  bytes.append(reinterpret_cast<const char*>(coordinates.data()), coordinates.size() * sizeof(float));
  bytes += static_cast<char>(corners.size());
  bytes.append(reinterpret_cast<const char*>(corners.data()), corners.size() * sizeof(int32_t));
  return bytes;
}

std::vector<BadPly> badPlys() {
  const std::string ascii = header("ascii 1.0"), points = "0 0 0\n1 0 0\n0 1 0\n";
  const std::string whole = littleEndian({0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 2});
  return {
      {"an index out of range, ascii", ascii + points + "3 0 1 3\n", {"line 13", "vertex 3"}},
      {"an index out of range, binary",
       littleEndian({0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 3}),
       {"byte", "vertex 3"}},
      {"a negative index", littleEndian({0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, -1}), {"byte"}},
      {"NaN, ascii", ascii + "0 0 0\n1 0 0\n0 nan 0\n3 0 1 2\n", {"line 12", "NaN"}},
      {"NaN, binary", littleEndian({0, 0, 0, 1, 0, NAN, 0, 1, 0}, {0, 1, 2}), {"byte", "NaN"}},
      {"infinity", littleEndian({0, 0, 0, 1, 0, INFINITY, 0, 1, 0}, {0, 1, 2}), {"byte", "infinite"}},
      {"no faces", header("ascii 1.0", 0) + points, {"no faces"}},
      {"a body that is truncated, ascii", ascii + points, {"truncated"}},
      {"a body that is truncated, binary", whole.substr(0, whole.size() - 1), {"truncated"}},
      {"a number that is none", ascii + "0 0 0\n1 zero 0\n0 1 0\n3 0 1 2\n", {"line 11"}},
      {"a single point", ascii + "1 1 1\n1 1 1\n1 1 1\n3 0 1 2\n", {}},
      {"another format", "solid cube\n", {}},
      {"nothing", "", {"empty"}},
  };
}

TEST(BadInput, isNamedByBuildWhichLeavesNothingBehind) {
  for (const BadPly& bad : badPlys()) {
    SCOPED_TRACE(bad.what);
    const WorkFolder folder;
    writeBytes(folder / "bad.ply", bad.bytes);
    std::filesystem::create_directory(folder / "tmp");
    const auto before = folder.contents();
    std::vector<std::string> named = bad.named;
    named.push_back("bad.ply");
    expectFailure(lodestreamd({"build", folder / "bad.ply", "-o", folder / "bad.lode", "--quiet"},
                              {"TMPDIR=" + (folder / "tmp").string()}),
                  named);
    EXPECT_EQ(folder.contents(), before);
  }
}

TEST(BadInput, keepsTheStoreOfAnEarlierBuild) {
  const WorkFolder folder;
  const auto store = makeSmallStore(folder);
  const std::string before = readBytes(store);
  std::filesystem::resize_file(folder / "small.ply", std::filesystem::file_size(folder / "small.ply") / 2);
  expectFailure(lodestreamd({"build", folder / "small.ply", "-o", store, "--quiet"}),
                {"small.ply", "truncated"});
  EXPECT_TRUE(readBytes(store) == before);
  EXPECT_EQ(folder.contents(), (std::vector<std::string>{"small.lode", "small.ply"}));
}

TEST(BadInput, isCountedByDoctorAsFarAsItCanBeRead) {
  const WorkFolder folder;
  writeBytes(folder / "cut.ply", header("ascii 1.0", 2) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  const Outcome outcome = lodestreamd({"doctor", folder / "cut.ply"});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.out.find("vertices          3\n"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("faces             1 of 2, 1 triangle\n"), std::string::npos) << outcome.out;
}

TEST(BadInput, isReportedAsAStoreIfItIsOne) {
  const WorkFolder folder;
  const auto store = makeSmallStore(folder);
  expectFailure(lodestreamd({"build", store, "-o", folder / "b.lode", "--quiet"}),
                {"small.lode", "is a store, not a PLY file", "lodestreamd export"});
}

TEST(BadInput, isNamedByEveryCommandIfItHasAnotherFormat) {
  const WorkFolder folder;
  const std::vector<std::string> cache{"XDG_CACHE_HOME=" + (folder / "cache").string()};
  const auto store = makeSmallStore(folder);
  writeBytes(folder / "cube.obj", "# a cube\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  writeBytes(folder / "photo.ply", "\xff\xd8\xff\xe0");
  for (const auto& [name, words] :
       {std::pair{"cube.obj", "is an OBJ, neither a PLY file nor a store; Lodestream reads PLY: convert it"},
        std::pair{"photo.ply", "is a JPEG picture, neither a PLY file nor a store; name the PLY file"}}) {
    SCOPED_TRACE(name);
    const std::string file = folder / name;
    for (const char* command : {"build", "verify", "info", "serve", "doctor", "export"}) {
      std::vector<std::string> arguments{command, file};
      if (*command == 'b') arguments.insert(arguments.end(), {"-o", folder / "b.lode", "--quiet"});
      if (*command == 'e') arguments.insert(arguments.end(), {"--error", "0", "-o", folder / "b.ply"});
      const Outcome outcome = lodestreamd(arguments);
      EXPECT_EQ(outcome.status, 1) << command;
      expectOneLine(outcome.err);
      EXPECT_NE(outcome.err.find(words), std::string::npos) << outcome.err;
    }
    expectFailure(lodestreamd({"verify", store, "--against", file}), {name, words});
    expectFailure(lodestream({"fetch", file, "-o", folder / "cut.ply"}, cache), {name, words});
  }
  EXPECT_EQ(folder.contents(),
            (std::vector<std::string>{"cube.obj", "photo.ply", "small.lode", "small.ply"}));
}

TEST(BadOutput, isRefusedByBuildIfItIsAnImageThatTheModelNames) {
  const WorkFolder folder;
  std::string named = header("ascii 1.0") + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  named.insert(named.find("element"), "comment TextureFile a.png\ncomment TextureFile b.png\n");
  writeBytes(folder / "a.ply", named);
  writeBytes(folder / "b.png", "a picture");
  const Outcome outcome = lodestreamd({"build", folder / "a.ply", "-o", folder / "b.png"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.err.find("b.png is a texture image of the input; name another output"), std::string::npos)
      << outcome.err;
  EXPECT_EQ(readBytes(folder / "b.png"), "a picture");
}

TEST(BadInput, isNamedByFetchWhichLeavesNothingBehind) {
  const WorkFolder folder;
  const std::vector<std::string> cache{"XDG_CACHE_HOME=" + (folder / "cache").string()};
  writeBytes(folder / "empty.lode", "");
  writeBytes(folder / "text.lode", "no store\n");
  writeBytes(folder / "empty.ply", "");
  writeBytes(folder / "nan.ply", header("ascii 1.0") + "0 0 0\n1 0 0\n0 nan 0\n3 0 1 2\n");
  std::filesystem::create_directory(folder / "folder.lode");
  for (const char* name :
       {"missing.lode", "missing.ply", "folder.lode", "empty.lode", "text.lode", "empty.ply", "nan.ply"}) {
    SCOPED_TRACE(name);
    expectFailure(lodestream({"fetch", folder / name, "-o", folder / "cut.ply"}, cache), {name});
  }
  // Succeeds only if the folder is empty.
  std::filesystem::remove(folder / "cache" / "lodestream" / "stores");
  std::filesystem::remove(folder / "cache" / "lodestream");
  std::filesystem::remove(folder / "cache");
  EXPECT_EQ(folder.contents(),
            (std::vector<std::string>{"empty.lode", "empty.ply", "folder.lode", "nan.ply", "text.lode"}));
  EXPECT_EQ(processesNaming(folder.path().string()), Processes{});
}

TEST(BadOutput, isNamedByFetchIfItCannotBeWritten) {
  const WorkFolder folder;
  const auto store = makeSmallStore(folder);
  const auto before = folder.contents();
  expectFailure(lodestream({"fetch", store, "-o", folder / "missing" / "cut.ply"}), {"missing/cut.ply"});
  EXPECT_EQ(folder.contents(), before);
}

TEST(BadInput, isNamedByFetchIfItIsNoCameraPath) {
  const WorkFolder folder;
  const auto store = makeSmallStore(folder);
  writeBytes(folder / "empty.json", "");
  writeBytes(folder / "none.json", R"({"keys": []})");
  for (const char* name : {"missing.json", "empty.json", "none.json"}) {
    SCOPED_TRACE(name);
    expectFailure(lodestream({"fetch", store, "--camera", folder / name}), {name});
  }
}

/// Occupies a loopback port by a socket, which may listen.
class TakenPort {
 public:
  explicit TakenPort(bool listens) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* const any = reinterpret_cast<sockaddr*>(&address);
    if (bind(socket_, any, size) != 0 || (listens && listen(socket_, 1) != 0) ||
        getsockname(socket_, any, &size) != 0)
      std::abort();
    address_ = "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
  }
  ~TakenPort() { close(socket_); }
  TakenPort(const TakenPort&) = delete;
  TakenPort& operator=(const TakenPort&) = delete;

  const std::string& address() const noexcept { return address_; }

 private:
  int socket_;
  std::string address_;
};

TEST(BadAddress, isNamedByServeIfThePortIsInUse) {
  const WorkFolder folder;
  const TakenPort taken(true);
  expectFailure(lodestreamd({"serve", makeSmallStore(folder), "--listen", taken.address()}),
                {taken.address()});
}

TEST(BadAddress, isNamedByTheClientIfNoServerListens) {
  const WorkFolder folder;
  const TakenPort closed(false);
  expectFailure(lodestream({"list", "lode://" + closed.address()}), {closed.address()});
  expectFailure(lodestream({"fetch", "lode://" + closed.address() + "/a", "-o", folder / "cut.ply"}),
                {closed.address()});
  EXPECT_TRUE(folder.contents().empty());
}

TEST(BadAddress, isNamedByTheClientIfTheServerIsSilent) {
  const TakenPort silent(true);
  expectFailure(lodestream({"list", "lode://" + silent.address(), "--timeout", "0.2"}), {silent.address()});
  expectFailure(lodestream({"fetch", "lode://" + silent.address() + "/a", "--timeout", "0.2"}),
                {silent.address()});
}

TEST(BadAddress, isNamedByFetchIfTheServerLacksTheModel) {
  const WorkFolder folder;
  RunningServer server({makeSmallStore(folder)});
  expectFailure(lodestream({"fetch", server.url("another"), "-o", folder / "cut.ply"}),
                {server.address(), "'another'"});
  EXPECT_EQ(folder.contents(), (std::vector<std::string>{"small.lode", "small.ply"}));
  EXPECT_EQ(server.stop().status, 0);
}

TEST(WrongUsageOfLodestream, exitsWithStatus2AndOneLine) {
  const std::vector<std::vector<std::string>> wrong{
      {},
      {"unknown"},
      {"fetch"},
      {"list"},
      {"list", "127.0.0.1:1"},
      {"list", "lode://127.0.0.1:1/model"},
      {"list", "lode://127.0.0.1:0"},
      {"fetch", "lode://127.0.0.1:1"},
      {"fetch", "http://127.0.0.1:1/a"},
      {"fetch", "lode://127.0.0.1:1/a", "--size", "0x5"},
      {"fetch", "lode://127.0.0.1:1/a", "--pixels", "0"},
      {"fetch", "lode://127.0.0.1:1/a", "--memory-budget", "1X"},
      {"fetch", "lode://127.0.0.1:1/a", "--bogus"},
      {"fetch", "lode://127.0.0.1:1/a", "more"},
      {"fetch", "lode://127.0.0.1:1/a", "--no-fade"},
      {"replay", "lode://127.0.0.1:1/a", "--no-fade"},
      {"loadtest", "lode://127.0.0.1:1/a", "--clients", "1", "--no-fade"},
      {"loadtest", "lode://127.0.0.1:1/a"},
      {"loadtest", "lode://127.0.0.1:1/a", "--clients", "0"},
      {"fetch", "lodes://127.0.0.1:1/a", "--ca-file", "/none.pem"},
      {"fetch", "lode://127.0.0.1:1/a", "--cache", "off", "--offline"},
      {"replay", "lode://127.0.0.1:1/a", "--fps", "0"}};
  for (const auto& arguments : wrong) {
    const Outcome outcome = lodestream(arguments);
    const std::string last = arguments.empty() ? "" : arguments.back();
    EXPECT_EQ(outcome.status, 2) << last;
    EXPECT_EQ(outcome.out, "") << last;
    expectOneLine(outcome.err);
  }
}

TEST(WrongUsageOfLodestream, isNamedIfTheCommandIsMistyped) {
  EXPECT_EQ(lodestream({"feetch", "x"}).err, "lodestream: unknown command: feetch: see lodestream --help\n");
}

TEST(Lodestream, opensAWindowOnATargetWithoutACommand) {
  const WorkFolder folder;
  const std::string missing = folder / "missing.ply";
  EXPECT_EQ(lodestream({missing}).err, lodestream({"view", missing}).err);
  const Outcome outcome = lodestream({missing, "--bogus"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_EQ(outcome.err, lodestream({"view", missing, "--bogus"}).err);
}

TEST(Lodestream, printsItsVersionForEveryCommand) {
  for (const char* command : {"", "fetch", "list"}) {
    std::vector<std::string> arguments{"--version"};
    if (*command) arguments.insert(arguments.begin(), command);
    const Outcome outcome = lodestream(arguments);
    EXPECT_EQ(outcome.status, 0) << command;
    EXPECT_TRUE(outcome.out.starts_with("lodestream ")) << command;
  }
}

}  // namespace
}  // namespace lode::test
