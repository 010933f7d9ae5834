#include "server/ingest/pipeline/build_identity.h"

#include <fstream>
#include <functional>
#include <string>
#include <type_traits>

#include <gtest/gtest.h>

#include "tests/support/work_folder.h"

namespace lode::ingest {
namespace {

constexpr size_t kBytes = 8 << 20;

struct BuildIdentityOf : testing::Test {
  BuildIdentityOf() {
    options.input = folder / "a.ply";
    options.output = folder / "a.lode";
    options.temporary_folder = folder.path();
    std::ofstream(options.input, std::ios::binary) << std::string(kBytes, 'a');
  }

  /// Changes a byte of the input, but not its size and time.
  void change(size_t at) const {
    const auto time = std::filesystem::last_write_time(options.input);
    std::fstream file(options.input, std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(static_cast<std::streamoff>(at));
    file.put('b');
    file.close();
    std::filesystem::last_write_time(options.input, time);
  }

  std::string differenceAfter(const std::function<void(BuildOptions&)>& change_options) const {
    BuildOptions changed = options;
    change_options(changed);
    return BuildIdentity::of(options).difference(BuildIdentity::of(changed));
  }

  test::WorkFolder folder;
  BuildOptions options;
};

TEST_F(BuildIdentityOf, isTheSameAfterBeingWritten) {
  const BuildIdentity identity = BuildIdentity::of(options);
  RecordWriter writer;
  identity.save(writer);
  RecordReader reader(writer.bytes());
  EXPECT_EQ(BuildIdentity::load(reader).difference(identity), "");
}

TEST_F(BuildIdentityOf, differsAfterAnyChangeThatKeepsSizeAndTimeOfTheInput) {
  for (const size_t at : {size_t{100}, kBytes / 2 + 100, kBytes - 1}) {
    const BuildIdentity before = BuildIdentity::of(options);
    change(at);
    EXPECT_NE(before.difference(BuildIdentity::of(options)).find("input has changed"), std::string::npos)
        << at;
  }
}

TEST_F(BuildIdentityOf, differsAfterAChangeOfTheInputsTimeOrSize) {
  const BuildIdentity before = BuildIdentity::of(options);
  const auto time = std::filesystem::last_write_time(options.input);
  std::filesystem::last_write_time(options.input, time + std::chrono::seconds(1));
  EXPECT_NE(before.difference(BuildIdentity::of(options)), "");
  std::filesystem::last_write_time(options.input, time);
  EXPECT_EQ(before.difference(BuildIdentity::of(options)), "");
  std::filesystem::resize_file(options.input, kBytes - 1);
  std::filesystem::last_write_time(options.input, time);
  EXPECT_NE(before.difference(BuildIdentity::of(options)), "");
}

TEST_F(BuildIdentityOf, differsAfterAChangeOfATextureImageAndNamesIt) {
  std::ofstream(options.input, std::ios::binary)
      << "ply\nformat ascii 1.0\ncomment TextureFile a.png\ncomment TextureFile maps/b c.png\n"
         "element vertex 0\nproperty float x\nend_header\n";
  std::filesystem::create_directory(folder / "maps");
  const auto image = folder / "maps" / "b c.png";
  const auto now = [&] { return BuildIdentity::of(options); };
  const BuildIdentity without = now();
  std::ofstream(image) << "one";
  const BuildIdentity before = now();
  EXPECT_NE(without.difference(before).find("'maps/b c.png' did not exist"), std::string::npos);
  EXPECT_NE(before.difference(without).find("'maps/b c.png' no longer exists"), std::string::npos);
  RecordWriter writer;
  before.save(writer);
  RecordReader reader(writer.bytes());
  EXPECT_EQ(BuildIdentity::load(reader).difference(now()), "");
  const auto time = std::filesystem::last_write_time(image);
  std::ofstream(image) << "two";
  std::filesystem::last_write_time(image, time);
  EXPECT_NE(before.difference(now()).find("'maps/b c.png' has changed"), std::string::npos) << "content";
  std::ofstream(image) << "one";
  std::filesystem::last_write_time(image, time + std::chrono::seconds(1));
  EXPECT_NE(before.difference(now()).find("'maps/b c.png' has changed"), std::string::npos) << "time";
}

TEST_F(BuildIdentityOf, differsIfAnImageIsFoundElsewhereButNotWithTheFolderAlone) {
  std::ofstream(options.input, std::ios::binary)
      << "ply\nformat ascii 1.0\ncomment TextureFile C:\\scan\\a.png\n"
         "element vertex 0\nproperty float x\nend_header\n";
  for (const char* name : {"here", "there"}) std::filesystem::create_directory(folder / name);
  std::ofstream(folder / "here" / "a.png") << "one";
  const auto in = [](const std::filesystem::path& textures) {
    return [=](BuildOptions& changed) { changed.textures_folder = textures; };
  };
  EXPECT_EQ(differenceAfter(in(folder / "here")), "") << "the same image";
  std::ofstream(folder / "there" / "a.png") << "one";
  BuildOptions before = options;
  before.textures_folder = folder / "here";
  EXPECT_NE(BuildIdentity::of(before)
                .difference([&] {
                  BuildOptions after = options;
                  after.textures_folder = folder / "there";
                  return BuildIdentity::of(after);
                }())
                .find((folder / "here" / "a.png").string()),
            std::string::npos);
}

TEST_F(BuildIdentityOf, differsWithEachResultOptionAndNamesIt) {
  forEachResultOption([&](const auto& option) {
    const std::string difference = differenceAfter([&](BuildOptions& changed) {
      auto& value = changed.*option.member;
      using Value = std::decay_t<decltype(value)>;
      value = value == Value{} ? static_cast<Value>(1) : Value{};
    });
    EXPECT_NE(difference.find(option.name), std::string::npos) << option.name;
  });
}

TEST_F(BuildIdentityOf, namesTheOptionThatTheBuildStartedWith) {
  const auto names = [&](const char* words, const std::function<void(BuildOptions&)>& change_options) {
    EXPECT_NE(differenceAfter(change_options).find(words), std::string::npos) << words;
  };
  names("--triangles-per-node 16384", [](BuildOptions& changed) { changed.triangles_per_node = 1000; });
  names("--simplifier collapse", [](BuildOptions& changed) { changed.simplifier = Simplifier::kCluster; });
  names("--crease-angle 44", [](BuildOptions& changed) { changed.crease_angle_deg = 40; });
  names("no --skip-bad", [](BuildOptions& changed) { changed.skip_bad = true; });
  names("a.ply", [&](BuildOptions& changed) { changed.input = folder / "b.ply"; });
  names("--tmp", [&](BuildOptions& changed) { changed.temporary_folder = folder / "other"; });
}

TEST_F(BuildIdentityOf, doesNotDifferWithThreadsAndMemory) {
  EXPECT_EQ(differenceAfter([](BuildOptions& changed) {
              changed.threads = 7;
              changed.memory_bytes = 12345678;
            }),
            "");
}

}  // namespace
}  // namespace lode::ingest
