#include "server/ingest/border_finder.h"

#include "server/ingest/leaf_mesh.h"

namespace lode::ingest {

BorderFinder::BorderFinder(BorderTable& table, AttributeSet attributes, unsigned threads)
    : attributes_(attributes), desks_(threads), found_(threads > 1 ? threads : 0, [&table](Found&& found) {
        for (size_t i = 0; i < found.positions.size(); ++i)
          table.add(found.positions[i], found.leaf, found.normals[i]);
      }) {}

void BorderFinder::add(uint32_t leaf, std::span<const std::byte> records) {
  Desk& desk = desks_[next_desk_++ % desks_.size()];
  found_.push([this, leaf, &desk, copy = std::vector(records.begin(), records.end())] {
    return find(leaf, copy, desk);
  });
}

BorderFinder::Found BorderFinder::find(uint32_t leaf, std::span<const std::byte> records, Desk& desk) const {
  const bool has_normals = attributes_.has(AttributeSet::kNormal);
  const NodeMesh mesh = weldSoup(records, attributes_, desk.welder);
  const std::vector<glm::i64vec3> normals = has_normals ? std::vector<glm::i64vec3>() : sumNormals(mesh);
  Found found{leaf, {}, {}};
  for (const uint32_t position : findBorder(mesh, desk.edges)) {
    found.positions.push_back(mesh.positions[position]);
    found.normals.push_back(has_normals ? glm::i64vec3(0) : normals[position]);
  }
  return found;
}

}  // namespace lode::ingest
