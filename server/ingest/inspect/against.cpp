#include "server/ingest/inspect/against.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "common/error.h"
#include "server/ingest/disk/record_sorter.h"
#include "server/ingest/inspect/lod_errors.h"
#include "server/ingest/mesh/number_table.h"
#include "server/ingest/plan/machine.h"
#include "server/ingest/soup/dereference.h"
#include "server/ingest/soup/scan.h"
#include "server/store/export.h"
#include "server/store/node_tree.h"
#include "server/store/reader.h"

namespace lode::ingest {
namespace {

constexpr double kLeastRatio = 0.8;
/// One LOD in this many may have a stored error below the measured error.
constexpr size_t kLodsOfOneBelow = 100;

/// A corner of a triangle, with the attributes that the input file has. A normal that the build computed
/// counts as 0.
struct Corner {
  uint64_t position;
  VertexAttributes attributes;
  uint32_t padding = 0;  // explicit, so that temporary files contain no uninitialized bytes

  bool operator==(const Corner&) const = default;
};

/// One side of the comparison: a triangle of the input, or a triangle of the store.
struct Side {
  std::array<Corner, 3> corners;
  int64_t balance;  ///< 1 for the input, -1 for the store; add() sums the balances of equal triangles
};

class Comparison {
 public:
  Comparison(const AgainstOptions& options, const BuildProgress& progress,
             std::optional<ErrorWitness>* witness)
      : options_(options),
        progress_(progress),
        witness_(witness),
        reader_(options.store),
        folder_(options.temporary_folder.empty() ? std::filesystem::temp_directory_path()
                                                 : options.temporary_folder),
        memory_bytes_(options.memory_bytes ? options.memory_bytes : defaultMemoryBytes()) {}

  AgainstReport run() {
    compareTriangles();
    compareErrors();
    return report_;
  }

 private:
  unsigned threads() const { return options_.threads > 0 ? options_.threads : defaultThreads(); }

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::kFormat, options_.store.string() + " against " + options_.input.string() + ": " +
                                        what + "; build the store again");
  }

  void compareTriangles() {
    RecordSorter sorter(sizeof(Side), memory_bytes_ / 4, folder_.file("against"));
    pushInput(sorter);
    pushStore(sorter);
    sorter.finish();
    std::vector<Side> same_key;
    uint64_t key = 0;
    while (const auto record = sorter.next()) {
      if (record->key != key) settle(same_key);
      key = record->key;
      Side side;
      std::memcpy(&side, record->bytes.data(), sizeof(side));
      add(side, same_key);
    }
    settle(same_key);
  }

  static void push(RecordSorter& sorter, Side side) {
    const auto first =
        std::min_element(side.corners.begin(), side.corners.end(),
                         [](const Corner& a, const Corner& b) { return a.position < b.position; });
    std::rotate(side.corners.begin(), first, side.corners.end());
    uint64_t key = 0;
    for (const Corner& corner : side.corners) key = NumberTable::hash(key * 31 + corner.position);
    sorter.push(key, std::as_bytes(std::span(&side, 1)));
  }

  static Side sideOfInput(const SoupTriangle& t) {
    Side side{{}, 1};
    for (size_t k = 0; k < 3; ++k) side.corners[k] = {t.corners[k].value, t.attributes[k]};
    return side;
  }

  void pushInput(RecordSorter& sorter) {
    BuildOptions build_options;
    build_options.input = options_.input;
    build_options.skip_bad = true;
    std::vector<std::string> warnings;
    const ScannedModel scanned = scan(build_options, folder_, progress_, warnings);
    const DereferenceCounts counts = dereference({.input = scanned.input,
                                                  .lattice = reader_.summary().lattice,
                                                  .memory_bytes = memory_bytes_ / 4,
                                                  .threads = threads(),
                                                  .progress = progress_},
                                                 [&](std::span<const SoupTriangle> triangles) {
                                                   for (const SoupTriangle& t : triangles)
                                                     push(sorter, sideOfInput(t));
                                                 });
    const UvGrid& grid = scanned.input.uvGrid();
    if (grid != UvGrid{reader_.textures().uv_origin, reader_.textures().uv_scale_exponent})
      fail("the range of texture coordinates differs from the store's");
    report_.triangles = counts.triangles;
    report_.dropped = counts.dropped + scanned.counts.dropped_triangles;
    if (report_.dropped != reader_.summary().dropped) {
      fail("the store records " + std::to_string(reader_.summary().dropped) +
           " dropped triangles, the input has " + std::to_string(report_.dropped) + " (I1)");
    }
  }

  void pushStore(RecordSorter& sorter) const {
    for (const Node& node : reader_.nodes()) {
      if (!node.isLeaf()) continue;
      const Mesh mesh = store::readLod(reader_, node, 0);
      for (const glm::u32vec3& t : mesh.triangles) {
        Side side{{}, -1};
        for (int k = 0; k < 3; ++k) {
          Corner& corner = side.corners[static_cast<size_t>(k)];
          corner.position = mesh.positions[t[k]].value;
          if (!mesh.vertex_attributes.empty()) corner.attributes = mesh.vertex_attributes[t[k]];
          if (mesh.attributes.has(AttributeSet::kComputedNormal)) corner.attributes.normal = 0;
        }
        push(sorter, side);
      }
    }
  }

  static void add(const Side& side, std::vector<Side>& same_key) {
    const auto at = std::find_if(same_key.begin(), same_key.end(),
                                 [&](const Side& other) { return other.corners == side.corners; });
    if (at == same_key.end()) {
      same_key.push_back(side);
    } else {
      at->balance += side.balance;
    }
  }

  void settle(std::vector<Side>& same_key) const {
    for (const Side& side : same_key) {
      if (side.balance == 0) continue;
      std::string corners;
      for (const Corner& corner : side.corners) {
        const glm::dvec3 at =
            reader_.summary().lattice.toWorld(unpackPosition(PositionCode{corner.position}));
        corners +=
            " (" + std::to_string(at.x) + " " + std::to_string(at.y) + " " + std::to_string(at.z) + ")";
      }
      fail("triangle" + corners + " is " +
           (side.balance > 0 ? "in the input, but not with these attributes in a leaf (I1)"
                             : "in a leaf more often than in the input (I1)"));
    }
    same_key.clear();
  }

  /// Returns the LODs to measure, spread evenly over the tree. Omits LOD 0 of each leaf, which is a copy of
  /// the input.
  std::vector<LodAt> chooseLods() const {
    std::vector<LodAt> all, chosen;
    for (const Node& node : reader_.nodes()) {
      for (uint32_t r = node.isLeaf() ? 1 : 0; r < node.lods.size(); ++r) {
        if (node.lods[r].triangles > 0) all.push_back({&node, r});
      }
    }
    if (options_.lods == 0 || all.size() <= options_.lods) return all;
    const size_t stride = (all.size() + options_.lods - 1) / options_.lods;
    for (size_t i = options_.seed % stride; i < all.size(); i += stride) chosen.push_back(all[i]);
    return chosen;
  }

  void compareErrors() {
    std::vector<double> ratios;
    const std::vector<LodAt> lods = chooseLods();
    const std::vector<MeasuredError> errors = measureLodErrors(
        reader_, lods,
        {.seed = options_.seed, .threads = threads(), .progress = [this](double fraction, uint64_t leaves) {
           if (progress_) progress_("measure", fraction, leaves, reader_.nodes().size());
         }});
    size_t worst = 0;
    for (size_t i = 0; i < lods.size(); ++i) {
      ratios.push_back(ratioOf(errors[i]));
      if (ratios[i] < ratios[worst]) worst = i;
      report_.lods_below += ratios[i] < 1;
    }
    report_.lods = ratios.size();
    if (ratios.empty()) return;
    const auto failAtWorst = [&](const std::string& what) {
      const ErrorWitness witness = witnessOf(reader_, lods[worst], errors[worst]);
      if (witness_ != nullptr) *witness_ = witness;
      fail(what + describe(witness) + " (I4)");
    };
    if (ratios[worst] < kLeastRatio) failAtWorst("");
    if (report_.lods_below > (report_.lods + kLodsOfOneBelow - 1) / kLodsOfOneBelow) {
      failAtWorst(std::to_string(report_.lods_below) + " of " + std::to_string(report_.lods) +
                  " LODs have a stored error below the measured error; the worst is ");
    }
    std::sort(ratios.begin(), ratios.end());
    report_.least_ratio = ratios.front();
    report_.median_ratio = ratios[ratios.size() / 2];
  }

  static double ratioOf(const MeasuredError& error) {
    return error.found.steps > 0 ? error.stored_steps / error.found.steps : 2;
  }

  const AgainstOptions& options_;
  const BuildProgress& progress_;
  std::optional<ErrorWitness>* const witness_;
  const store::Reader reader_;
  const TemporaryFolder folder_;
  const uint64_t memory_bytes_;
  AgainstReport report_;
};

}  // namespace

AgainstReport compareWithInput(const AgainstOptions& options, const BuildProgress& progress,
                               std::optional<ErrorWitness>* witness) {
  return Comparison(options, progress, witness).run();
}

}  // namespace lode::ingest
