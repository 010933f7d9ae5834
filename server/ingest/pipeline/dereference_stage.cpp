#include "server/ingest/pipeline/dereference_stage.h"

#include <algorithm>

#include "common/error.h"
#include "server/ingest/disk/checkpoint_clock.h"
#include "server/ingest/mesh/cell_code.h"
#include "server/ingest/mesh/soup_triangle.h"
#include "server/ingest/soup/dereference.h"
#include "server/ingest/soup/lost_triangles.h"

namespace lode::ingest {
namespace {

constexpr std::string_view kRunsFile = "runs";
constexpr uint64_t kTrianglesBetweenLooks = 1 << 16;  ///< at the clock

/// Notes runs of a sort that are written, and where the sort was then.
class SortLog {
 public:
  SortLog(BuildSession& session, RecordSorter& sorter)
      : session_(session), sorter_(sorter), runs_(sorter.runCount()) {}

  void beginBatch(const DereferencePoint& batch) { batch_ = batch; }
  void afterTriangle() {
    // Where memory is ample, the first run may be long in coming.
    if (sorter_.size() % kTrianglesBetweenLooks == 0 &&
        CheckpointClock::Clock::now() - last_run_ > CheckpointClock::kLatest)
      sorter_.spill();
    if (sorter_.runCount() != runs_) noteRuns();
  }

 private:
  void noteRuns() {
    runs_ = sorter_.runCount();
    last_run_ = CheckpointClock::Clock::now();
    if (!clock_.isDue(last_run_)) return;
    RecordWriter record;
    record.put(batch_);
    sorter_.save(record);
    session_.note(BuildEntry::kSorting, record.bytes());
    clock_.noted(last_run_, CheckpointClock::Clock::now());
  }

  BuildSession& session_;
  RecordSorter& sorter_;
  DereferencePoint batch_;
  size_t runs_;
  CheckpointClock::Clock::time_point last_run_ = CheckpointClock::Clock::now();
  CheckpointClock clock_{last_run_};
};

}  // namespace

DereferenceStage::DereferenceStage(BuildSession& session, ScanStage& scan)
    : Stage({.name = "dereference",
             .entry = BuildEntry::kDereferenced,
             .used_up_by = BuildEntry::kPartitioned,
             .files = {kRunsFile}}),
      session_(session),
      scan_(scan) {}

void DereferenceStage::openSorter() {
  sorter_ =
      std::make_unique<RecordSorter>(soupBytes(session_.facts().soup_attributes), session_.plan().sort_bytes,
                                     session_.files().lastingFile(kRunsFile), session_.plan().threads);
}

Stage::Work DereferenceStage::run() {
  openSorter();
  sortSoup(*scan_.takeInput());
  checkCounts();
  sorter_->finish([&](uint64_t done, uint64_t total) {
    if (const BuildProgress& progress = session_.progress())
      progress("sort", static_cast<double>(done) / static_cast<double>(total), done, total);
  });
  return {session_.facts().counts.triangles, sorter_->temporaryBytes()};
}

void DereferenceStage::checkCounts() {
  const DereferenceCounts& counts = session_.facts().counts;
  const LatticeChoice& choice = session_.facts().choice;
  const LostTriangles lost{counts.lost, counts.triangles + counts.dropped, choice.lattice.step, choice.min,
                           choice.max};
  const std::string input = session_.options().input.string() + ": ";
  if (lost.areMost()) throw Error(ErrorCode::kInput, input + lost.inWords());
  if (counts.triangles == 0)
    throw Error(ErrorCode::kInput, input + "no face has three distinct corners; check the file");
  if (lost.lost > 0) session_.warn(input + lost.inWords());
}

/// What a killed build had in runs is not pushed again, but its triangles in the batch that it was at are
/// looked up again.
void DereferenceStage::sortSoup(const PackedInput& input) {
  DereferencePoint begin;
  uint64_t known = 0;
  if (!session_.recorded().sorting.empty()) {
    RecordReader record(session_.recorded().sorting);
    begin = record.get<DereferencePoint>();
    sorter_->restore(record);
    if (sorter_->size() < begin.counts.triangles)
      throw Error(ErrorCode::kFormat,
                  "the journal of a build names no point of a sort; build without --resume");
    known = sorter_->size() - begin.counts.triangles;
  }
  BuildFacts& facts = session_.facts();
  const CellGrid grid(facts.choice.extent);
  sorter_->reserve(input.faceCount());
  std::byte bytes[kMaxSoupBytes];
  const std::span<std::byte> soup(bytes, soupBytes(facts.soup_attributes));
  SortLog log(session_, *sorter_);
  log.beginBatch(begin);
  facts.counts = dereference(
      input, facts.choice.lattice, session_.plan().sort_bytes, session_.plan().threads,
      [&](std::span<const SoupTriangle> triangles) {
        const uint64_t pushed = std::min<uint64_t>(known, triangles.size());
        known -= pushed;
        for (const SoupTriangle& triangle : triangles.subspan(pushed)) {
          storeSoup(triangle, soup);
          sorter_->push(grid.code(triangle), soup);
          log.afterTriangle();
        }
      },
      session_.progress(), begin, [&](const DereferencePoint& point) { log.beginBatch(point); });
}

void DereferenceStage::load(RecordReader& record, bool is_used_up) {
  if (is_used_up) return;
  openSorter();
  sorter_->restore(record);
  sorter_->finish();
}

}  // namespace lode::ingest
