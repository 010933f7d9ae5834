#include "server/ingest/border_finder.h"

#include "server/ingest/leaf_mesh.h"

namespace lode::ingest {
namespace {

constexpr size_t kWaitingLeaves = 2;

}  // namespace

BorderFinder::BorderFinder(BorderTable& table, AttributeSet attributes, bool in_own_thread)
    : table_(table), attributes_(attributes), waiting_(kWaitingLeaves) {
  if (in_own_thread) thread_ = std::thread([this] { listInOwnThread(); });
}

BorderFinder::~BorderFinder() { stop(); }

void BorderFinder::add(uint32_t leaf, std::span<const std::byte> records) {
  if (!thread_.joinable()) return list(leaf, records);
  if (!waiting_.push({leaf, {records.begin(), records.end()}})) finish();
}

void BorderFinder::finish() {
  stop();
  if (failure_) std::rethrow_exception(failure_);
}

void BorderFinder::stop() noexcept {
  waiting_.close();
  if (thread_.joinable()) thread_.join();
}

void BorderFinder::listInOwnThread() noexcept {
  try {
    while (const auto leaf = waiting_.pop()) list(leaf->number, leaf->records);
  } catch (...) {
    failure_ = std::current_exception();
    waiting_.close();
  }
}

void BorderFinder::list(uint32_t leaf, std::span<const std::byte> records) {
  const bool has_normals = attributes_.has(AttributeSet::kNormal);
  const NodeMesh mesh = weldSoup(records, attributes_, welder_);
  const std::vector<glm::i64vec3> normals = has_normals ? std::vector<glm::i64vec3>() : sumNormals(mesh);
  for (const uint32_t position : findBorder(mesh, edges_))
    table_.add(mesh.positions[position], leaf, has_normals ? glm::i64vec3(0) : normals[position]);
}

}  // namespace lode::ingest
