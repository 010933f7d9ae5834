// Tests of fetch and list. Models are served on loopback and fetched until they have converged.

#include <algorithm>
#include <array>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "models.h"
#include "programs.h"
#include "server/ingest/ply/ply_reader.h"
#include "server/store/export.h"
#include "server/store/reader.h"

namespace lode::test {
namespace {

using Json = nlohmann::json;

/// The triangles of a cut's file, as position indices. Vertices at the same position share an index.
struct CutFile {
  std::vector<std::array<uint32_t, 3>> triangles;

  explicit CutFile(const std::filesystem::path& ply) {
    ingest::PlyReader reader(ply, {});
    std::map<std::array<double, 3>, uint32_t> number_of;
    std::vector<uint32_t> numbers;
    reader.read(
        [&](uint64_t, std::span<const ingest::PlyVertex> vertices) {
          for (const auto& [p, normal, colour, texture] : vertices) {
            const auto next = static_cast<uint32_t>(number_of.size());
            numbers.push_back(number_of.try_emplace({p.x, p.y, p.z}, next).first->second);
          }
        },
        [&](const ingest::PlyFaces& faces) {
          for (size_t i = 0; i + 2 < faces.corners.size(); i += 3)
            triangles.push_back(
                {numbers[faces.corners[i]], numbers[faces.corners[i + 1]], numbers[faces.corners[i + 2]]});
        });
  }

  /// Counts the edges that an odd number of triangles use.
  size_t openEdges() const {
    std::vector<std::pair<uint32_t, uint32_t>> edges;
    for (const auto& [a, b, c] : triangles)
      for (const auto& [from, to] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)})
        edges.push_back(std::minmax(from, to));
    std::sort(edges.begin(), edges.end());
    size_t open = 0;
    for (size_t i = 0, next = 0; i < edges.size(); i = next) {
      while (next < edges.size() && edges[next] == edges[i]) ++next;
      open += (next - i) % 2;
    }
    return open;
  }
};

void expectFiguresOfAConvergedFetch(const Json& json) {
  EXPECT_EQ(json.value("converged", false), true);
  for (const char* key : {"first_image_ms", "converged_ms", "bytes_received", "final_cut_bytes", "triangles",
                          "nodes", "max_error_px"}) {
    ASSERT_TRUE(json.contains(key) && json[key].is_number()) << key;
    EXPECT_GT(json[key], 0) << key;
  }
  EXPECT_LE(json["first_image_ms"], json["converged_ms"]);
  if (json.contains("keys") && json["keys"].size() == 1) {
    EXPECT_EQ(json["keys"][0]["converged_ms"], json["converged_ms"]);
  }
  EXPECT_LE(json["final_cut_bytes"], json["bytes_received"]);
}

class Fetch : public testing::TestWithParam<Model> {
 protected:
  void SetUp() override { LODE_REQUIRE_MODEL(GetParam()); }

  Json fetch(const RunningServer& server, const std::string& output,
             const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"fetch", server.url(GetParam().name), "--json", "-o",
                                       folder_ / output};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = lodestream(arguments);
    EXPECT_EQ(outcome.status, 0);
    EXPECT_EQ(outcome.err, "");
    expectOneLine(outcome.out);
    return Json::parse(outcome.out, nullptr, false);
  }

  /// Writes a camera path that frames the model, then approaches one of its sides.
  std::string writeApproach() const {
    const ModelSummary model = store::Reader(GetParam().store()).summary();
    const glm::dvec3 low = model.lattice.toWorld(model.box.min), high = model.lattice.toWorld(model.box.max);
    const glm::dvec3 middle = (low + high) / 2.0, away(0, 0, glm::length(high - low));
    const auto key = [](double t, glm::dvec3 eye, glm::dvec3 target) {
      return Json{{"t", t},
                  {"eye", {eye.x, eye.y, eye.z}},
                  {"target", {target.x, target.y, target.z}},
                  {"up", {0, 1, 0}}};
    };
    const glm::dvec3 corner = low + (high - low) * glm::dvec3(0.8, 0.7, 1.1);
    const Json path{{"fov_y_deg", 45}, {"keys", {key(0, middle + away, middle), key(1, corner, middle)}}};
    writeBytes(folder_ / "approach.json", path.dump());
    return folder_ / "approach.json";
  }

  WorkFolder folder_;
};

TEST_P(Fetch, convergesAtOnePixelToTheSameCutEveryTime) {
  RunningServer server({GetParam().store()});
  const Json json = fetch(server, "a.ply");
  expectFiguresOfAConvergedFetch(json);
  EXPECT_LE(json["max_error_px"], 1);
  ASSERT_EQ(json["keys"].size(), 1u);
  expectFiguresOfAConvergedFetch(json["keys"][0]);

  const Json again = fetch(server, "b.ply");
  EXPECT_EQ(again["triangles"], json["triangles"]);
  EXPECT_TRUE(readBytes(folder_ / "a.ply") == readBytes(folder_ / "b.ply"));

  const CutFile cut(folder_ / "a.ply");
  EXPECT_EQ(cut.triangles.size(), json["triangles"]);
  EXPECT_EQ(cut.openEdges() == 0, GetParam().is_closed) << cut.openEdges();
  const Outcome end = server.stop();
  EXPECT_EQ(end.status, 0);
  std::istringstream log(end.err);
  for (std::string line; std::getline(log, line);)
    EXPECT_TRUE(line.find("reason=client") != std::string::npos ||
                line.find("server: stopping") != std::string::npos)
        << line;
}

TEST_P(Fetch, leavesNoCrackBetweenNearAndFarParts) {
  RunningServer server({GetParam().store()});
  const Json json = fetch(server, "near.ply", {"--camera", writeApproach(), "--size", "640x480"});
  expectFiguresOfAConvergedFetch(json);
  ASSERT_EQ(json["keys"].size(), 2u);
  for (const Json& key : json["keys"]) EXPECT_TRUE(key["converged"]);
  const CutFile cut(folder_ / "near.ply");
  EXPECT_EQ(cut.triangles.size(), json["triangles"]);
  EXPECT_EQ(cut.openEdges() == 0, GetParam().is_closed) << cut.openEdges();
}

TEST_P(Fetch, receivesAFiftiethAtMostOnASecondVisitAndNothingOffline) {
  RunningServer server({GetParam().store()});
  const std::vector<std::string> cache{"--cache", folder_ / "kept"};
  const Json first = fetch(server, "a.ply", cache);
  const Json second = fetch(server, "b.ply", cache);
  EXPECT_EQ(first["cache_bytes"], 0);
  EXPECT_LT(second["bytes_received"].get<uint64_t>(),
            std::max<uint64_t>(first["bytes_received"].get<uint64_t>() / 50, 1000));
  EXPECT_TRUE(readBytes(folder_ / "a.ply") == readBytes(folder_ / "b.ply"));
  server.stop();
  const Json offline = fetch(server, "c.ply", {"--cache", folder_ / "kept", "--offline"});
  EXPECT_EQ(offline["bytes_received"], 0);
  EXPECT_TRUE(readBytes(folder_ / "a.ply") == readBytes(folder_ / "c.ply"));
}

TEST(FetchOffline, failsAtOnceIfTheCacheLacksBlobs) {
  const WorkFolder folder;
  RunningServer server({makeSmallStore(folder)});
  const std::string url = server.url("small"), kept = folder / "kept";
  EXPECT_EQ(lodestream({"fetch", url, "--cache", kept, "--json"}).status, 0);
  server.stop();
  std::filesystem::remove_all(folder / "kept/blobs");
  constexpr double kTimeoutS = 20;
  const Outcome outcome = lodestream(
      {"fetch", url, "--cache", kept, "--offline", "--timeout", std::to_string(kTimeoutS), "--json"});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.err.find("without --offline"), std::string::npos) << outcome.err;
  EXPECT_LT(Json::parse(outcome.out)["waited_s"]["link"], kTimeoutS / 2);
}

INSTANTIATE_TEST_SUITE_P(Of, Fetch, testing::ValuesIn(models()), nameOf);

TEST(FetchOfAFile, servesAStoreByAChildThatEndsWithIt) {
  const WorkFolder folder;
  const auto store = makeSmallStore(folder);
  const auto before = folder.contents();
  const Outcome outcome =
      lodestream({"fetch", store, "--json"}, {"XDG_CACHE_HOME=" + (folder / "cache").string()});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  expectFiguresOfAConvergedFetch(Json::parse(outcome.out, nullptr, false));
  EXPECT_EQ(processesNaming(folder.path().string()), Processes{});
  EXPECT_EQ(folder.contents(), before);
}

/// Writes a camera file with one key.
void writeCamera(const std::filesystem::path& file, glm::dvec3 eye, glm::dvec3 target, glm::dvec3 up) {
  const auto asJson = [](glm::dvec3 v) { return Json{v.x, v.y, v.z}; };
  const Json key{{"t", 0}, {"eye", asJson(eye)}, {"target", asJson(target)}, {"up", asJson(up)}};
  writeBytes(file, Json{{"fov_y_deg", 45}, {"keys", {key}}}.dump());
}

TEST(FetchOfAFile, convergesOnTheOriginalTrianglesEvenIfALatticeStepIsVisible) {
  const WorkFolder folder;
  const auto store = makeSmallStore(folder);
  const store::Reader reader(store);
  const Mesh leaf = store::readLod(reader, reader.nodes().back(), 0);
  const glm::dvec3 eye = reader.summary().lattice.toWorld(unpackPosition(leaf.positions.front()));
  writeCamera(folder / "near.json", eye, {0, 0, 0}, {0, 1, 0});
  const Outcome outcome =
      lodestream({"fetch", store, "--json", "--camera", folder / "near.json", "-o", folder / "cut.ply"},
                 {"XDG_CACHE_HOME=" + (folder / "cache").string()});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const Json json = Json::parse(outcome.out, nullptr, false);
  EXPECT_TRUE(json["converged"]);
  EXPECT_TRUE(json["finest"]);
  EXPECT_GT(json["max_error_px"], 1);
  EXPECT_EQ(CutFile(folder / "cut.ply").triangles.size(), json["triangles"]);
}

TEST(FetchOfAFile, tellsThatItShowsOnlyAPreview) {
  const WorkFolder folder;
  const std::filesystem::path ply = folder / "a.ply";
  ASSERT_EQ(lodestreamd({"sample", "asteroid", "--triangles", "20000", "-o", ply}).status, 0);
  const std::vector<std::string> cache{"XDG_CACHE_HOME=" + (folder / "cache").string()};
  const Outcome preview = lodestream({"fetch", ply, "--preview"}, cache);
  EXPECT_EQ(preview.status, 0) << preview.err;
  EXPECT_EQ(preview.out.find("only a preview, at most "), 0u) << preview.out;
  EXPECT_EQ(preview.out.find("converged"), std::string::npos) << preview.out;
  for (const bool is_preview : {true, false}) {
    std::vector<std::string> arguments{"fetch", ply, "--json", "--pixels", "4"};
    if (is_preview) arguments.emplace_back("--preview");
    const Json json = Json::parse(lodestream(arguments, cache).out, nullptr, false);
    EXPECT_EQ(json["preview"], is_preview);
  }
}

TEST(FetchOfAFile, tellsTheStoreOfAPreviewFromASmallModel) {
  const WorkFolder folder;
  const std::filesystem::path ply = folder / "a.ply";
  ASSERT_EQ(lodestreamd({"sample", "asteroid", "--triangles", "2000", "-o", ply}).status, 0);
  ASSERT_EQ(
      lodestreamd({"build", ply, "-o", folder / "a.lode", "--preview", folder / "a.preview.lode"}).status, 0);
  for (const char* store : {"a.lode", "a.preview.lode"}) {
    const Json json = Json::parse(lodestream({"fetch", folder / store, "--json"}).out, nullptr, false);
    EXPECT_EQ(json["preview"], store == std::string("a.preview.lode")) << store;
  }
}

TEST(FetchOfAFile, measuresTheErrorFromTheWallsOfARoomNotFromItsBox) {
  const WorkFolder folder;
  writeBytes(folder / "room.ply",
             "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
             "element face 6\nproperty list uchar int vertex_indices\nend_header\n"
             "0 0 0\n22 0 0\n22 20 0\n0 20 0\n0 0 3\n22 0 3\n22 20 3\n0 20 3\n"
             "4 0 1 2 3\n4 7 6 5 4\n4 0 4 5 1\n4 1 5 6 2\n4 2 6 7 3\n4 3 7 4 0\n");
  writeCamera(folder / "inside.json", {11, 12, 1.5}, {11, 20, 1.5}, {0, 0, 1});
  const Outcome outcome =
      lodestream({"fetch", folder / "room.ply", "--json", "--camera", folder / "inside.json"},
                 {"XDG_CACHE_HOME=" + (folder / "cache").string()});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const Json json = Json::parse(outcome.out, nullptr, false);
  EXPECT_TRUE(json["converged"]);
  EXPECT_FALSE(json["finest"]);
  EXPECT_LT(json["max_error_px"], 1) << "a lattice step of 5 mm; what is visible of the floor is 4 m away";
  EXPECT_EQ(json["triangles"], 12);
}

TEST(FetchOfAFile, buildsAPlyIntoTheCacheOnce) {
  const WorkFolder folder;
  makeSmallStore(folder);
  const auto fetch = [&] {
    const Outcome outcome = lodestream({"fetch", folder / "small.ply", "-o", folder / "cut.ply"},
                                       {"XDG_CACHE_HOME=" + (folder / "cache").string()});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    EXPECT_EQ(processesNaming(folder.path().string()), Processes{});
  };
  fetch();
  const auto built = folder.contents();
  const auto store = std::find_if(built.begin(), built.end(), [](const std::string& name) {
    return name.starts_with("cache/") && name.ends_with("/small.lode");
  });
  ASSERT_NE(store, built.end());
  const auto built_at = std::filesystem::last_write_time(folder / *store);
  fetch();
  EXPECT_EQ(folder.contents(), built);
  EXPECT_EQ(std::filesystem::last_write_time(folder / *store), built_at);
  const CutFile cut(folder / "cut.ply");
  EXPECT_GT(cut.triangles.size(), 100u);
  EXPECT_EQ(cut.openEdges(), 0u);
}

TEST(ClientCommands, failIfStandardOutputIsFull) {
  const WorkFolder folder;
  const std::string store = makeSmallStore(folder);
  RunningServer server({store});
  const std::string url = server.url("small");
  for (const std::string& arguments :
       {std::string("--help"), std::string("--version"), std::string("fetch --help"), "fetch " + url,
        "fetch --json " + url, "replay " + url, "replay --json " + url, "list " + server.url(),
        "list --json " + server.url(), "loadtest --clients 1 --seconds 0.2 " + url,
        "loadtest --json --clients 1 --seconds 0.2 " + url}) {
    SCOPED_TRACE(arguments);
    const std::string command = "'" LODE_BIN_DIR "/bin/lodestream' " + arguments + " >/dev/full";
    expectFailure(Program("sh", {"-c", command}, {"XDG_CACHE_HOME=" + folder.path().string()}).wait(),
                  {"cannot write to standard output"});
  }
}

TEST(ClientCommands, explainThemselvesInText) {
  for (const char* command : {"view", "render", "fetch", "replay", "loadtest", "list"}) {
    const Outcome outcome = lodestream({command, "--help"});
    EXPECT_EQ(outcome.status, 0) << command;
    const auto isText = [](char c) { return c == '\n' || (c >= ' ' && c <= '~'); };
    EXPECT_TRUE(std::ranges::all_of(outcome.out, isText)) << outcome.out;
  }
}

TEST(List, namesTheModelsOfAServerInOrder) {
  const WorkFolder folder;
  const auto store = makeSmallStore(folder);
  std::filesystem::copy(store, folder / "another.lode");
  RunningServer server({folder.path()});
  const Outcome lines = lodestream({"list", server.url()});
  EXPECT_EQ(lines.status, 0) << lines.err;
  EXPECT_EQ(std::count(lines.out.begin(), lines.out.end(), '\n'), 2) << lines.out;
  EXPECT_TRUE(lines.out.starts_with("another "));

  const Outcome outcome = lodestream({"list", server.url(), "--json"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  expectOneLine(outcome.out);
  const Json models = Json::parse(outcome.out, nullptr, false)["models"];
  ASSERT_EQ(models.size(), 2u);
  const Json info = Json::parse(lodestreamd({"info", store, "--json"}).out);
  EXPECT_EQ(models[0]["name"], "another");
  EXPECT_EQ(models[1]["name"], "small");
  for (const char* key : {"triangles", "nodes", "bytes", "depth"})
    EXPECT_EQ(models[1][key], info[key]) << key;
}

}  // namespace
}  // namespace lode::test
