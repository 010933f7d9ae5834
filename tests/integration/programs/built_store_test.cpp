// Tests of a client that opens a PLY file. The client builds a store, keeps the store in its cache and reuses
// it.

#include <csignal>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/file.h>
#include <unistd.h>

#include "programs.h"
#include "tests/support/bytes.h"
#include "tests/support/work_folder.h"

namespace lode::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class BuiltStore : public testing::Test {
 protected:
  std::vector<std::string> fetchOf(const fs::path& ply) const {
    return {"fetch", ply.string(), "--json", "--pixels", "4"};
  }
  Outcome fetch(const fs::path& ply) const { return lodestream(fetchOf(ply), environment_); }
  /// Lists the stores in the cache.
  std::vector<fs::path> stores() const {
    std::vector<fs::path> found;
    for (const auto& entry : fs::recursive_directory_iterator(folder_ / "cache"))
      if (entry.path().extension() == ".lode") found.push_back(entry.path());
    return found;
  }

  const WorkFolder folder_;
  const std::vector<std::string> environment_{"XDG_CACHE_HOME=" + (folder_ / "cache").string()};
};

TEST_F(BuiltStore, isBuiltOnceIfTwoProgramsOpenTheFileAtOnce) {
  const fs::path ply = folder_ / "a.ply";
  ASSERT_EQ(lodestreamd({"sample", "asteroid", "--triangles", "60000", "-o", ply}).status, 0);
  Program first("lodestream", fetchOf(ply), environment_), second("lodestream", fetchOf(ply), environment_);
  std::set<fs::file_time_type> built;
  for (Program* const program : {&first, &second}) {
    const Outcome outcome = program->wait();
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    ASSERT_EQ(stores().size(), 1u);
    built.insert(fs::last_write_time(stores().front()));
  }
  EXPECT_EQ(built.size(), 1u);
}

TEST_F(BuiltStore, isNamedByACommandThatKeepsIt) {
  const fs::path ply = folder_ / "a.ply";
  ASSERT_EQ(lodestreamd({"sample", "asteroid", "--triangles", "2000", "-o", ply}).status, 0);
  const Outcome first = lodestream({"store", ply}, environment_);
  EXPECT_EQ(first.status, 0) << first.err;
  ASSERT_EQ(stores().size(), 1u);
  EXPECT_EQ(first.out, stores().front().string() + "\n");
  const fs::file_time_type built = fs::last_write_time(stores().front());
  ASSERT_EQ(fetch(ply).status, 0);
  EXPECT_EQ(fs::last_write_time(stores().front()), built) << "other commands use the same store";
  EXPECT_EQ(lodestream({"store", stores().front()}, environment_).out, first.out);
  EXPECT_EQ(lodestream({"store", "lode://here/a"}, environment_).status, 2);
  EXPECT_EQ(lodestream({"store", folder_ / "gone.ply"}, environment_).status, 1);
}

TEST_F(BuiltStore, isRebuiltIfTheFileChangesButKeepsItsSizeAndTime) {
  const fs::path ply = folder_ / "a.ply", other = folder_ / "other.ply";
  ASSERT_EQ(lodestreamd({"sample", "asteroid", "--triangles", "2000", "-o", ply}).status, 0);
  ASSERT_EQ(lodestreamd({"sample", "asteroid", "--triangles", "2000", "--seed", "2", "-o", other}).status, 0);
  ASSERT_EQ(fs::file_size(ply), fs::file_size(other));
  ASSERT_EQ(fetch(ply).status, 0);
  const std::string before = readBytes(stores().at(0));
  const fs::file_time_type time = fs::last_write_time(ply);
  fs::copy_file(other, ply, fs::copy_options::overwrite_existing);
  fs::last_write_time(ply, time);
  ASSERT_EQ(fetch(ply).status, 0);
  EXPECT_NE(readBytes(stores().at(0)), before);
}

/// Stops a process, and returns when it is stopped.
void stop(pid_t process) {
  kill(process, SIGSTOP);
  const std::string status = "/proc/" + std::to_string(process) + "/stat";
  while (readBytes(status).find(") T ") == std::string::npos) std::this_thread::yield();
}

TEST_F(BuiltStore, staysLockedUntilItsBuilderEndsEvenIfTheClientIsKilled) {
  const fs::path ply = folder_ / "a.ply";
  ASSERT_EQ(lodestreamd({"sample", "asteroid", "--triangles", "60000", "-o", ply}).status, 0);
  Program first("lodestream", fetchOf(ply), environment_);
  Processes builders;
  while (builders.empty()) builders = processesNaming("lodestreamd build " + ply.string());
  const pid_t builder = builders.begin()->first;
  stop(builder);
  first.signal(SIGKILL);
  first.wait();
  const int lock = open(waitForFile(folder_ / "cache", "lock").c_str(), O_RDWR | O_CLOEXEC);
  EXPECT_EQ(flock(lock, LOCK_EX | LOCK_NB), -1);
  kill(builder, SIGKILL);
  EXPECT_EQ(flock(lock, LOCK_EX), 0);
  close(lock);
  EXPECT_EQ(fetch(ply).status, 0);
}

TEST_F(BuiltStore, keepsWarningsOfAsManyImagesAsAPlyMayName) {
  const fs::path ply = folder_ / "a.ply";
  std::string header = "ply\nformat ascii 1.0\n";
  for (int i = 0; i < 4096; ++i) header += "comment TextureFile missing_" + std::to_string(i) + ".png\n";
  writeBytes(ply, header +
                      "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                      "property float s\nproperty float t\nelement face 1\n"
                      "property list uchar int vertex_indices\nend_header\n"
                      "0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n3 0 1 2\n");
  for (int times = 0; times < 2; ++times) {
    const Outcome outcome = fetch(ply);
    EXPECT_EQ(outcome.status, 0);
    EXPECT_NE(outcome.err.find("missing_4095.png"), std::string::npos) << outcome.err.size();
  }
}

TEST_F(BuiltStore, isReplacedIfTheFileChanges) {
  const fs::path ply = folder_ / "a.ply";
  ASSERT_EQ(lodestreamd({"sample", "asteroid", "--triangles", "1000", "-o", ply}).status, 0);
  ASSERT_EQ(fetch(ply).status, 0);
  const auto before = stores();
  ASSERT_EQ(fetch(ply).status, 0);
  EXPECT_EQ(stores(), before);
  ASSERT_EQ(lodestreamd({"sample", "asteroid", "--triangles", "2000", "-o", ply}).status, 0);
  ASSERT_EQ(fetch(ply).status, 0);
  EXPECT_EQ(stores().size(), 1u);
  EXPECT_NE(stores(), before);
}

/// A PNG file of one pixel, in hexadecimal digits.
constexpr std::string_view kRed =
    "89504e470d0a1a0a0000000d4948445200000001000000010802000000907753de0000000c49444154789c63f8"
    "cfc0000003010100c9fe92ef0000000049454e44ae426082";
constexpr std::string_view kGreen =
    "89504e470d0a1a0a0000000d4948445200000001000000010802000000907753de0000000c49444154789c6360"
    "f8cf0000020201007b0981780000000049454e44ae426082";

void writeImage(const fs::path& file, std::string_view digits) {
  std::string bytes;
  for (size_t i = 0; i < digits.size(); i += 2)
    bytes += static_cast<char>(std::stoi(std::string(digits.substr(i, 2)), nullptr, 16));
  writeBytes(file, bytes);
}

TEST_F(BuiltStore, isRebuiltIfAnImageAppearsOrChanges) {
  const fs::path ply = folder_ / "a.ply", image = folder_ / "red.png";
  writeBytes(ply,
             "ply\nformat ascii 1.0\ncomment TextureFile red.png\nelement vertex 4\nproperty float x\n"
             "property float y\nproperty float z\nproperty float s\nproperty float t\nelement face 1\n"
             "property list uchar int vertex_indices\nend_header\n"
             "0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n0 1 0 0 1\n4 0 1 2 3\n");
  for (int times = 0; times < 2; ++times) {
    const Outcome outcome = fetch(ply);
    EXPECT_EQ(outcome.status, 0);
    EXPECT_NE(outcome.err.find("warning: "), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("red.png"), std::string::npos) << outcome.err;
    EXPECT_EQ(Json::parse(outcome.out).value("tiles", -1), 0);
  }
  std::set<std::string> seen;
  for (const std::string_view digits : {kRed, kGreen}) {
    writeImage(image, digits);
    const Outcome outcome = fetch(ply);
    EXPECT_EQ(outcome.err, "");
    EXPECT_EQ(Json::parse(outcome.out).value("tiles", -1), 1);
    ASSERT_EQ(stores().size(), 1u);
    seen.insert(readBytes(stores().front()));
  }
  EXPECT_EQ(seen.size(), 2u);
}

/// A PLY of a square whose image has a path of another machine.
void writeSquareOfAnotherMachine(const fs::path& ply) {
  writeBytes(ply,
             "ply\nformat ascii 1.0\ncomment TextureFile C:\\scan\\maps\\red.png\nelement vertex 4\n"
             "property float x\nproperty float y\nproperty float z\nproperty float s\nproperty float t\n"
             "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
             "0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n0 1 0 0 1\n4 0 1 2 3\n");
}

TEST_F(BuiltStore, isRebuiltOnlyIfAnImageIsFoundElsewhere) {
  const fs::path ply = folder_ / "a.ply", other = folder_ / "other";
  writeSquareOfAnotherMachine(ply);
  fs::create_directories(folder_ / "below");
  fs::create_directories(other);
  writeImage(folder_ / "below" / "RED.png", kRed);
  const auto built = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = fetchOf(ply);
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = lodestream(arguments, environment_);
    EXPECT_EQ(outcome.err, "");
    EXPECT_EQ(Json::parse(outcome.out).value("tiles", -1), 1);
    return fs::last_write_time(stores().at(0));
  };
  const fs::file_time_type first = built({});
  EXPECT_EQ(built({}), first);
  EXPECT_EQ(built({"--textures", other}), first) << "the same image";
  writeImage(other / "red.png", kGreen);
  const fs::file_time_type second = built({"--textures", other});
  EXPECT_NE(second, first);
  EXPECT_EQ(built({"--textures", other}), second);
  writeImage(folder_ / "red.png", kGreen);
  EXPECT_NE(built({}), second);
}

TEST_F(BuiltStore, namesTheLastTextureFolderInTheWarningOfAMissingImage) {
  const fs::path ply = folder_ / "a.ply";
  writeSquareOfAnotherMachine(ply);
  EXPECT_NE(fetch(ply).err.find("--textures"), std::string::npos);
  for (const char* name : {"one", "two"}) {
    fs::create_directories(folder_ / name);
    std::vector<std::string> arguments = fetchOf(ply);
    arguments.insert(arguments.end(), {"--textures", folder_ / name});
    const Outcome outcome = lodestream(arguments, environment_);
    EXPECT_NE(outcome.err.find((folder_ / name).string()), std::string::npos) << outcome.err;
  }
}

TEST_F(BuiltStore, isRebuiltIfAnImageAppearedDuringTheBuild) {
  const fs::path ply = folder_ / "a.ply";
  ASSERT_EQ(
      lodestreamd({"sample", "asteroid", "--triangles", "60000", "--attributes", "uv", "-o", ply}).status, 0);
  std::string bytes = readBytes(ply);
  bytes.insert(bytes.find("element"), "comment TextureFile red.png\n");
  writeBytes(ply, bytes);
  Program program("lodestream", fetchOf(ply), environment_);
  waitForFile(folder_ / "cache", ".lode");  // the store gets this name when the build is over
  writeImage(folder_ / "red.png", kRed);
  EXPECT_EQ(program.wait().status, 0);
  EXPECT_EQ(Json::parse(fetch(ply).out).value("tiles", -1), 1);
}

TEST_F(BuiltStore, doesNotReplaceTheFileThatItIsBuiltOf) {
  const fs::path ply = folder_ / "a.ply";
  ASSERT_EQ(lodestreamd({"sample", "asteroid", "--triangles", "1000", "-o", ply}).status, 0);
  const auto bytes = fs::file_size(ply);
  const Outcome outcome = lodestream({"fetch", ply, "-o", ply}, environment_);
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.err.find("is the input; name another output"), std::string::npos) << outcome.err;
  EXPECT_EQ(fs::file_size(ply), bytes);
}

}  // namespace
}  // namespace lode::test
