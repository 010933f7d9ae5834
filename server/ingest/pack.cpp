#include "server/ingest/pack.h"

#include "server/store/writer.h"

namespace lode::ingest {

ModelSummary pack(const std::filesystem::path& output, ModelSummary summary, SimplifiedTree tree,
                  const PayloadSpool& payloads, const BuildProgress& progress) {
  store::Writer writer(output);
  for (size_t n = 0; n < tree.nodes.size(); ++n) {
    for (size_t r = tree.nodes[n].rungs.size(); r-- > 0;) {
      const PayloadSpool::Place place = tree.payloads[n][r];
      if (place.bytes > 0) tree.nodes[n].rungs[r].payload = writer.addBlob(payloads.read(place));
    }
    if (progress && n % 256 == 0) {
      progress("pack", static_cast<double>(n) / static_cast<double>(tree.nodes.size()), n, tree.nodes.size());
    }
  }
  return writer.finish(std::move(summary), std::move(tree.nodes));
}

}  // namespace lode::ingest
