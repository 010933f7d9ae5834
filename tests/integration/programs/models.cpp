#include "models.h"

#include <cstdlib>

namespace lode::test {
namespace {

std::filesystem::path scan(const char* file) {
  const char* folder = std::getenv("LODESTREAM_TEST_DATA");
  return std::filesystem::path(folder ? folder : "") / file;
}

std::filesystem::path modelFolder() { return std::filesystem::path(LODE_BIN_DIR) / "test-models"; }

}  // namespace

std::filesystem::path Model::store() const { return modelFolder() / (name + ".lode"); }

const std::vector<Model>& models() {
  static const std::vector<Model> all{
      {"bunny", scan("a_bunny_zipper_ascii.ply"), false},
      {"armadillo", scan("a_armadillo86k_le.ply"), true},
      {"painted", modelFolder() / "painted.ply", true},
      {"asteroid2m", modelFolder() / "asteroid2m.ply", true},
      {"gyroid", modelFolder() / "gyroid.ply", true},
      {"bunny_in_small_nodes", scan("a_bunny_zipper_ascii.ply"), false},
      {"parasaurolophus", scan("b_parasaurolophus_nrm_ascii.ply"),
       false},  // not closed: a third of the model's edges are boundary edges
  };
  return all;
}

}  // namespace lode::test
