// Tests of lodestreamd's command lines as scripts use them: exit statuses, one line on stderr, JSON keys.

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "programs.h"

namespace lode::test {
namespace {

using Json = nlohmann::json;

class ServerCommands : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(run("sample asteroid --triangles 20000 --attributes normal,color -o a.ply").status, 0);
  }

  /// Runs lodestreamd in the test's folder.
  Outcome run(const std::string& arguments) const {
    std::vector<std::string> words{"-C", folder_.path(), LODE_BIN_DIR "/bin/lodestreamd"};
    std::istringstream in(arguments);
    words.insert(words.end(), std::istream_iterator<std::string>(in), {});
    return Program("env", words).wait();
  }

  void build() const { ASSERT_EQ(run("build a.ply -o a.lode --triangles-per-node 2000 --quiet").status, 0); }

  static void expectKeys(const Json& json, const std::vector<std::string>& keys) {
    for (const std::string& key : keys) EXPECT_TRUE(json.contains(key)) << key;
  }

  static void expectWithinHalf(double forecast, double actual) {
    EXPECT_LE(forecast, 1.5 * actual);
    EXPECT_GE(forecast, actual / 1.5);
  }
  /// Expects that the memory is within half of the forecast. With a sanitizer, expects nothing, because the
  /// forecast does not include the sanitizer's memory.
  static void expectMemoryWithinHalf([[maybe_unused]] double forecast, [[maybe_unused]] double actual) {
#ifndef LODE_SANITIZED
    expectWithinHalf(forecast, actual);
#endif
  }

  WorkFolder folder_;
};

TEST_F(ServerCommands, printTheJsonThatScriptsRelyOn) {
  const Json built = Json::parse(run("build a.ply -o a.lode --triangles-per-node 2000 --json").out);
  expectKeys(built, {"triangles", "dropped", "nodes", "payloads", "stored_triangles", "bytes", "seconds",
                     "cpu_seconds", "peak_rss_bytes", "stages"});
  EXPECT_EQ(built["bytes"], std::filesystem::file_size(folder_ / "a.lode"));

  const Json info = Json::parse(run("info a.lode --json").out);
  expectKeys(info, {"triangles", "nodes", "depth", "bytes", "box", "origin", "step", "attributes", "textures",
                    "lods", "max_error"});
  expectKeys(info["box"], {"min", "max"});
  EXPECT_EQ(info["attributes"], (Json{"normal", "color"}));
  EXPECT_EQ(info["triangles"], built["triangles"]);
  EXPECT_EQ(info["largest_inputs"][0]["nodes"], 1);
  EXPECT_GT(info["largest_inputs"][0]["triangles"], 0);

  const Json cut = Json::parse(run("export a.lode --triangles 3000 -o cut.ply --json").out);
  expectKeys(cut, {"triangles", "nodes", "bytes", "max_error"});
  EXPECT_LE(cut["triangles"], 3000);
  EXPECT_TRUE(cut["converged"]);
  EXPECT_TRUE(Json::parse(run("verify a.lode --json").out)["sound"]);
}

TEST_F(ServerCommands, printTheProgressOfEachBuildStageAsJson) {
  std::istringstream lines(run("build a.ply -o a.lode --triangles-per-node 2000 --json-progress").out);
  std::vector<std::string> stages;
  double last = 0;
  for (std::string line; std::getline(lines, line);) {
    const Json progress = Json::parse(line);
    EXPECT_GE(progress["fraction"], 0);
    EXPECT_LE(progress["fraction"], 1);
    const std::string stage = progress["stage"];
    if (!stages.empty() && stages.back() != stage) {
      EXPECT_EQ(last, 1) << stages.back();
    }
    last = progress["fraction"];
    if (stages.empty() || stages.back() != stage) stages.push_back(stage);
  }
  EXPECT_EQ(last, 1) << stages.back();
  std::erase(stages, "border");  // only large models have this stage
  EXPECT_EQ(stages,
            (std::vector<std::string>{"scan", "dereference", "sort", "partition", "simplify", "pack"}));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "a.lode"));
}

TEST_F(ServerCommands, doctorForecastsTheCostOfABuildWithinHalf) {
  const Json doctor = Json::parse(run("doctor a.ply --json").out);
  expectKeys(doctor, {"buildable", "encoding", "elements", "vertices", "faces", "triangles", "attributes",
                      "textures", "box", "topology", "problems", "forecast"});
  EXPECT_TRUE(doctor["buildable"]);
  EXPECT_EQ(doctor["topology"]["open_edges"], 0);
  EXPECT_EQ(doctor["topology"]["pieces"], 1);
  const Json built = Json::parse(run("build a.ply -o a.lode --json").out);
  EXPECT_EQ(doctor["triangles"], built["triangles"]);
  expectMemoryWithinHalf(doctor["forecast"]["memory_bytes"], built["peak_rss_bytes"]);
  expectWithinHalf(doctor["forecast"]["store_bytes"], built["bytes"]);
}

TEST_F(ServerCommands, doctorForecastsTheCostOfATexturedBuildWithinHalf) {
  const char* const data = std::getenv("LODESTREAM_TEST_DATA");
  if (data == nullptr) GTEST_SKIP() << "set LODESTREAM_TEST_DATA to the folder with MANIFEST.tsv";
  for (const char* model : {"c_steampunk_3tex_le", "c_jungle_multitex_le", "c_fuze_spaces_le"}) {
    SCOPED_TRACE(model);
    const std::string input = std::string(data) + "/" + model + ".ply --json";
    const Json forecast = Json::parse(run("doctor " + input).out)["forecast"];
    const Json built = Json::parse(run("build " + input + " -o a.lode").out);
    expectMemoryWithinHalf(forecast["memory_bytes"], built["peak_rss_bytes"]);
    expectWithinHalf(forecast["store_bytes"], built["bytes"]);
  }
}

TEST_F(ServerCommands, doctorFailsForAnUnbuildableFileButStillDescribesIt) {
  std::filesystem::copy(folder_ / "a.ply", folder_ / "cut.ply");
  std::filesystem::resize_file(folder_ / "cut.ply", 100000);
  const Outcome outcome = run("doctor cut.ply --json");
  EXPECT_EQ(outcome.status, 1);
  const Json doctor = Json::parse(outcome.out);
  EXPECT_FALSE(doctor["buildable"]);
  EXPECT_EQ(doctor["encoding"], "binary_little_endian");
  EXPECT_EQ(doctor["problems"].size(), 1u);
  expectOneLine(outcome.err);
  EXPECT_EQ(run("doctor missing.ply").status, 1);
}

TEST_F(ServerCommands, infoPrintsOneJsonObjectPerLineForEachLod) {
  build();
  const Json info = Json::parse(run("info a.lode --json").out);
  std::istringstream lines(run("info a.lode --nodes --json").out);
  uint64_t lods = 0, leaf_triangles = 0;
  for (std::string line; std::getline(lines, line); ++lods) {
    const Json node = Json::parse(line);
    expectKeys(node, {"key", "depth", "lod", "leaf", "triangles", "locked", "bytes", "error",
                      "appearance_error", "box"});
    if (node["leaf"]) leaf_triangles += node["triangles"].get<uint64_t>();
  }
  EXPECT_EQ(lods, info["lods"]);
  EXPECT_EQ(leaf_triangles, info["triangles"]);
}

TEST_F(ServerCommands, infoPrintsATableOfNodesForPeople) {
  build();
  std::istringstream lines(run("info a.lode --nodes").out);
  std::string line;
  ASSERT_TRUE(std::getline(lines, line));
  EXPECT_TRUE(line.starts_with("depth LOD")) << line;
  uint64_t lods = 0, leaf_triangles = 0;
  for (; std::getline(lines, line); ++lods) {
    uint64_t depth = 0, lod = 0, triangles = 0;
    std::istringstream(line) >> depth >> lod >> triangles;
    if (line.ends_with("(leaf)")) leaf_triangles += triangles;
  }
  const Json info = Json::parse(run("info a.lode --json").out);
  EXPECT_EQ(lods, info["lods"]);
  EXPECT_EQ(leaf_triangles, info["triangles"]);
}

TEST_F(ServerCommands, exitWithStatus2AndOneLineOnWrongUsage) {
  build();
  for (const char* arguments :
       {"", "unknown", "info", "info a.lode --bogus", "build a.ply", "build a.ply -o b.lode --memory 1XB",
        "build a.ply -o a.ply", "build a.ply -o b.lode --threads 0", "export a.lode -o b.ply",
        "export a.lode --error 1 --triangles 2 -o b.ply", "export a.lode --error -1 -o b.ply",
        "export a.lode --error 0.1 -o a.lode", "sample cube --triangles 100 -o b.ply", "serve",
        "serve a.lode --listen 0.0.0.0:0", "serve a.lode --tls-cert x"}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 2) << arguments;
    EXPECT_EQ(outcome.out, "") << arguments;
    expectOneLine(outcome.err);
  }
  EXPECT_EQ(folder_.contents(), (std::vector<std::string>{"a.lode", "a.ply"}));
}

TEST_F(ServerCommands, listUnknownOptionsInTheOrderInWhichTheyWereGiven) {
  EXPECT_NE(run("doctor a.ply --one --two --three").err.find("--one --two --three"), std::string::npos);
}

TEST_F(ServerCommands, nameAnUnknownCommand) {
  EXPECT_EQ(run("biuld a.ply -o b.lode").err.rfind("lodestreamd: unknown command: biuld", 0), 0u);
}

TEST_F(ServerCommands, exportRefusesEndingsOfFormatsThatItDoesNotWrite) {
  build();
  const Outcome outcome = run("export a.lode --error 0.01 -o cut.stl");
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.err.find("cut.stl: PLY, OBJ and GLB can be written"), std::string::npos) << outcome.err;
  EXPECT_EQ(folder_.contents(), (std::vector<std::string>{"a.lode", "a.ply"}));
}

TEST_F(ServerCommands, exitWithStatus1AndOneLineOnFailureAndLeaveNothingBehind) {
  build();
  writeBytes(folder_ / "empty.ply", "");
  std::filesystem::copy(folder_ / "a.ply", folder_ / "cut.ply");
  std::filesystem::resize_file(folder_ / "cut.ply", 100000);
  std::filesystem::copy(folder_ / "a.lode", folder_ / "cut.lode");
  std::filesystem::resize_file(folder_ / "cut.lode", 100000);
  const std::vector<std::string> before = folder_.contents();
  for (const char* arguments :
       {"build missing.ply -o b.lode", "build . -o b.lode", "build empty.ply -o b.lode",
        "build cut.ply -o b.lode", "build a.ply -o missing/b.lode", "info missing.lode", "info .",
        "info a.ply", "info cut.lode", "verify cut.lode", "export cut.lode --error 0.1 -o b.ply",
        "export a.lode --triangles 1 -o b.ply", "export a.lode --error 0.1 -o missing/b.ply",
        "serve missing.lode"}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 1) << arguments;
    EXPECT_EQ(outcome.out, "") << arguments;
    expectOneLine(outcome.err);
  }
  EXPECT_EQ(folder_.contents(), before);
}

TEST_F(ServerCommands, exportTheFinestCutForAnErrorOfZero) {
  build();
  const Json info = Json::parse(run("info a.lode --json").out);
  const Outcome outcome = run("export a.lode -o b.ply --json --error 0");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const Json cut = Json::parse(outcome.out);
  EXPECT_EQ(cut["triangles"], info["triangles"]);
  EXPECT_TRUE(cut["finest"]);
  EXPECT_TRUE(cut["converged"]);
  EXPECT_GT(cut["max_error"], 0);
  const std::string text = run("export a.lode -o b.ply --error 0").out;
  EXPECT_NE(text.find("that of the lattice; the store has nothing finer"), std::string::npos) << text;
}

TEST_F(ServerCommands, exportTheFinestCutButFailForAnErrorBelowTheLattice) {
  build();
  const Json info = Json::parse(run("info a.lode --json").out);
  const Outcome outcome = run("export a.lode -o b.ply --json --error 1e-12");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.err.find("even the finest cut, which was written"), std::string::npos) << outcome.err;
  const Json cut = Json::parse(outcome.out);
  EXPECT_EQ(cut["triangles"], info["triangles"]);
  EXPECT_FALSE(cut["converged"]);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "b.ply"));
}

TEST_F(ServerCommands, printOnlyTheMeshOnStdoutIfItGoesThere) {
  build();
  for (const char* arguments : {"export a.lode --error 0.01 -o ", "sample asteroid --triangles 1000 -o "}) {
    ASSERT_EQ(run(std::string(arguments) + "b.ply").status, 0);
    const Outcome outcome = run(std::string(arguments) + "/dev/stdout");
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(outcome.out, readBytes(folder_ / "b.ply"));
    EXPECT_NE(outcome.err.find("triangles"), std::string::npos) << outcome.err;
    EXPECT_EQ(run(std::string(arguments) + "/dev/stdout --json").status, 2);
  }
}

TEST_F(ServerCommands, refuseAFolderAsOutputBeforeAnyWork) {
  std::filesystem::create_directory(folder_ / "folder");
  const std::vector<std::string> before = folder_.contents();
  for (const char* command :
       {"build a.ply -o ", "build a.ply --resume -o ", "sample asteroid --triangles 100 -o "}) {
    const Outcome outcome = run(std::string(command) + "folder");
    EXPECT_EQ(outcome.status, 2) << command;
    EXPECT_NE(outcome.err.find("folder: is a folder: name a file"), std::string::npos) << outcome.err;
    expectOneLine(outcome.err);
  }
  EXPECT_EQ(lodestreamd({"build", folder_ / "a.ply", "-o", ""}).status, 2);
  EXPECT_EQ(folder_.contents(), before);
}

TEST_F(ServerCommands, buildIntoTheTargetOfAnOutputLink) {
  std::filesystem::create_directory(folder_ / "stores");
  std::filesystem::create_symlink("stores/first.lode", folder_ / "a.lode");
  build();
  EXPECT_TRUE(std::filesystem::is_symlink(folder_ / "a.lode"));
  EXPECT_EQ(folder_.contents().size(), 4u) << "the model, the link, the folder and the store";
  EXPECT_EQ(run("verify stores/first.lode --quiet").status, 0);
}

TEST_F(ServerCommands, warnOfAStoreWithoutTheEndingLode) {
  const Json built = Json::parse(run("build a.ply -o a.txt --json").out);
  ASSERT_EQ(built["warnings"].size(), 1u);
  EXPECT_NE(built["warnings"][0].get<std::string>().find("end in .lode"), std::string::npos);
}

TEST_F(ServerCommands, refuseOutputsWithAMissingOrUnknownEnding) {
  build();
  for (const char* arguments :
       {"sample asteroid --triangles 100 -o b.obj", "export a.lode --error 0 -o cut"}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 2) << arguments;
    EXPECT_NE(outcome.err.find("give a name that ends in .ply"), std::string::npos) << outcome.err;
  }
  EXPECT_EQ(folder_.contents(), (std::vector<std::string>{"a.lode", "a.ply"}));
}

TEST_F(ServerCommands, pointToTheHelpOfTheCommandThatWasCalled) {
  EXPECT_NE(run("build a.ply --bogus").err.find("see lodestreamd build --help"), std::string::npos);
  EXPECT_NE(run("build a.ply").err.find("see lodestreamd build --help"), std::string::npos);
  EXPECT_NE(run("bogus").err.find("see lodestreamd --help"), std::string::npos);
}

TEST_F(ServerCommands, nameTheRemedyForInvalidNumbers) {
  const auto expectWords = [&](const char* arguments, const char* words) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 2) << arguments;
    EXPECT_NE(outcome.err.find(words), std::string::npos) << outcome.err;
  };
  expectWords("build a.ply -o b.lode --memory 1XB", "512MB, 1.5GB or 512MiB");
  expectWords("serve . --memory-budget 0.5", "512MB, 1.5GB or 512MiB");
  expectWords("serve . --memory-budget 0.5KB", "0.5KB is less than 1.0 MB");
  expectWords("build a.ply -o b.lode --memory 0", "0 is less than 1 byte");
  expectWords("build a.ply -o b.lode --triangles-per-node 63", "1048576");
  expectWords("serve . --idle-deadline 0", "--idle-deadline");
  expectWords("sample asteroid --triangles -5 -o b.ply", "a whole number such as 2000000, not -5");
  expectWords("sample nope --triangles 5 -o b.ply", "scene");
}

TEST_F(ServerCommands, takeFractionsOfMegabytesEverywhere) {
  EXPECT_EQ(run("build a.ply -o a.lode --memory 0.2GB --quiet").status, 0);
  EXPECT_EQ(run("doctor a.ply --memory 100.5MiB").status, 0);
}

TEST_F(ServerCommands, reportHowManyBadValuesABuildSkips) {
  writeBytes(folder_ / "bad.ply",
             "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
             "element face 3\nproperty list uchar int vertex_indices\nend_header\n"
             "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 1 9\n3 0 1 1\n");
  const Outcome outcome = run("build bad.ply -o bad.lode --skip-bad");
  EXPECT_EQ(outcome.status, 0);
  EXPECT_NE(outcome.err.find("1 bad indices, coordinates or faces were skipped"), std::string::npos)
      << outcome.err;
  EXPECT_NE(outcome.out.find("1 triangle in 1 node, "), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("2 flat or bad triangles dropped"), std::string::npos) << outcome.out;
  EXPECT_EQ(Json::parse(run("build bad.ply -o bad.lode --skip-bad --json").out)["warnings"].size(), 1u);
}

TEST_F(ServerCommands, reportThatNoFaceIsLeftIfAllAreBad) {
  writeBytes(folder_ / "bad.ply",
             "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
             "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
             "0 0 0\n1 0 0\n0 1 0\n3 0 1 9\n");
  expectFailure(run("build bad.ply -o bad.lode --skip-bad"), {"no usable face, with 1 bad value skipped"});
}

TEST_F(ServerCommands, warnOfTextureCoordinatesWithoutAnImageAsDoctorDoes) {
  ASSERT_EQ(run("sample asteroid --triangles 100 --attributes uv -o uv.ply").status, 0);
  const std::string words = "its header names no image";
  EXPECT_NE(run("build uv.ply -o uv.lode").err.find(words), std::string::npos);
  EXPECT_NE(run("doctor uv.ply").out.find(words), std::string::npos);
}

TEST_F(ServerCommands, warnEvenWithQuiet) {
  ASSERT_EQ(run("sample asteroid --triangles 100 --attributes uv -o uv.ply").status, 0);
  const Outcome outcome = run("build uv.ply -o uv.lode --quiet");
  EXPECT_NE(outcome.err.find("warning: "), std::string::npos) << outcome.err;
  EXPECT_EQ(outcome.out, "");
}

TEST_F(ServerCommands, adviseAnotherOutputIfItsFolderCannotBeWritten) {
  const Outcome outcome = run("build a.ply -o nowhere/a.lode --tmp .");
  expectFailure(outcome, {"nowhere", "choose another output folder"});
  EXPECT_EQ(outcome.err.find("--tmp"), std::string::npos) << outcome.err;
}

TEST_F(ServerCommands, doctorWritesNumbersAsTheFileHasThem) {
  writeBytes(folder_ / "b.ply",
             "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
             "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
             "0.1 0 0\n1.3 0 0\n0.1 1 0\n3 0 1 2\n");
  const std::string text = run("doctor b.ply").out;
  EXPECT_NE(text.find("[0.1, 0, 0] to [1.3, 1, 0]"), std::string::npos) << text;
  EXPECT_NE(text.find("1, 1 triangle\n"), std::string::npos) << text;
}

TEST_F(ServerCommands, tellTheirVersionEverywhere) {
  for (const char* command : {"", "build ", "doctor ", "serve ", "info ", "verify ", "export ", "sample "}) {
    const Outcome outcome = run(std::string(command) + "--version");
    EXPECT_EQ(outcome.status, 0) << command;
    EXPECT_TRUE(outcome.out.starts_with("lodestreamd ")) << command;
  }
}

TEST_F(ServerCommands, failIfStandardOutputIsFull) {
  build();
  for (const char* arguments :
       {"--help", "--version", "info --help", "info a.lode", "info a.lode --json", "info a.lode --nodes",
        "info a.lode --nodes --json", "doctor a.ply", "doctor a.ply --json", "verify a.lode --quiet",
        "verify a.lode --json --quiet", "build a.ply -o b.lode --json --quiet",
        "export a.lode --triangles 3000 -o b.ply", "export a.lode --triangles 3000 -o b.ply --json",
        "sample asteroid --triangles 100 -o c.ply", "serve a.lode --listen 127.0.0.1:0"}) {
    SCOPED_TRACE(arguments);
    const std::string command = "cd '" + folder_.path().string() +
                                "' && '" LODE_BIN_DIR "/bin/lodestreamd' " + arguments + " >/dev/full";
    expectFailure(Program("sh", {"-c", command}).wait(), {"cannot write to standard output"});
  }
}

}  // namespace
}  // namespace lode::test
