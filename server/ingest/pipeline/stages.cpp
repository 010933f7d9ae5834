#include "server/ingest/pipeline/stages.h"

#include <algorithm>
#include <array>
#include <span>

#include "common/error.h"
#include "server/ingest/disk/journal.h"
#include "server/ingest/mesh/cell_code.h"
#include "server/ingest/mesh/soup_triangle.h"
#include "server/ingest/pipeline/pack.h"
#include "server/ingest/ply/ply_reader.h"
#include "server/ingest/preview/preview.h"
#include "server/ingest/soup/dereference.h"
#include "server/ingest/soup/former_lattice.h"
#include "server/ingest/soup/lost_triangles.h"
#include "server/ingest/soup/scan.h"
#include "server/store/writer.h"

namespace lode::ingest {
namespace {

/// Finds the images that an input names. Fails if an image does not fit in memory, because a store without
/// this image would depend on --memory. @throws Error kLimit.
std::vector<TextureImage> findImages(BuildSession& session, std::span<const NamedImage> names) {
  const BuildOptions& options = session.options();
  std::vector<TextureImage> images =
      surveyTextures(names, options.textures_folder, session.plan().image_bytes);
  for (const TextureImage& image : images)
    if (image.needs_memory)
      session.refuseForMemory(textureInWords(image.ply, image.name) + " " + image.problem);
  return images;
}

/// Chooses the lattice as the options say. @throws Error kInput if the model does not fit on it.
LatticeChoice chooseLattice(BuildSession& session, const PackedInput& input) {
  const BuildOptions& options = session.options();
  const LatticeChoice chosen = ingest::chooseLattice(input, options.input, options.step_model);
  if (options.lattice_of.empty()) {
    if (options.reuse_folder.empty() || options.step_model > 0) return chosen;
    try {
      const FormerLattice former = FormerLattice::of(options.output);
      return former.suits(chosen) ? former.chosenFor(chosen) : chosen;
    } catch (const Error&) {  // no store to replace
      return chosen;
    }
  }
  const FormerLattice former = FormerLattice::of(options.lattice_of);
  if (!former.reaches(chosen))
    throw Error(ErrorCode::kInput, options.input.string() + ": extends beyond the lattice of " +
                                       options.lattice_of.string() + "; build without --lattice-of");
  return former.chosenFor(chosen);
}

constexpr std::string_view kRunsFile = "runs";
constexpr uint64_t kTrianglesPerClockCheck = 1 << 16;

/// Records in the journal which sorted runs are on disk and which batch of faces the sort is reading.
class SortLog {
 public:
  SortLog(BuildSession& session, RecordSorter& sorter)
      : session_(session), sorter_(sorter), runs_(sorter.runCount()) {}

  void beginBatch(const DereferencePoint& batch) { batch_ = batch; }
  void afterTriangle() {
    // Write a run when a checkpoint is due, even if memory is left. Otherwise a kill could lose much work.
    if (sorter_.size() % kTrianglesPerClockCheck == 0 &&
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

ScanStage::ScanStage(BuildSession& session)
    : Stage({.name = "scan",
             .entry = BuildEntry::kScanned,
             .used_up_by = BuildEntry::kDereferenced,
             .files = {PackedInput::kVertexFile, PackedInput::kFaceFile}}),
      session_(session) {}

Stage::Work ScanStage::run() {
  const BuildOptions& options = session_.options();
  {
    // Check the images before the long scan, so that errors appear at once.
    const PlyReader reader(options.input, {.skip_bad = options.skip_bad});
    if (reader.attributes().has(AttributeSet::kTexture))
      images_ = findImages(session_, listImages(inputsOf(options), options.textures_folder).images);
  }
  std::vector<std::string> warnings;
  ScannedModel scanned = scan(options, session_.files(), session_.progress(), warnings);
  session_.warn(warnings);
  noteFacts(scanned.input, scanned.counts.dropped_triangles);
  if (scanned.input.attributes().has(AttributeSet::kTexture)) {
    named_images_ = std::move(scanned.images);
    if (named_images_.empty()) session_.warn(options.input.string() + ": " + kNoTextureFile);
  } else if (!scanned.images.empty()) {
    session_.warn(options.input.string() +
                  ": names texture files, but has no texture coordinates; the build ignores the files");
  }
  input_ = std::make_unique<PackedInput>(std::move(scanned.input));
  return {input_->vertexCount() + input_->faceCount(), input_->temporaryBytes()};
}

void ScanStage::noteFacts(const PackedInput& input, uint64_t dropped_triangles) {
  BuildFacts& facts = session_.facts();
  facts.choice = chooseLattice(session_, input);
  facts.soup_attributes = input.attributes();
  facts.uv_grid = input.uvGrid();
  facts.dropped_triangles = dropped_triangles;
}

void ScanStage::writePreview() const {
  const BuildOptions& options = session_.options();
  if (options.preview.empty() || !input_) return;
  const uint64_t needed_bytes = previewBytes(*input_);
  if (needed_bytes > options.memory_bytes / 2)
    return session_.warn(budgetBelowInWords(2 * needed_bytes, "a preview") + "; no preview was written");
  const bool is_written =
      ingest::writePreview(options.preview, *input_, session_.facts().choice, textureColours());
  if (is_written && session_.progress()) session_.progress()(kPreviewStage, 1, 0, 0);
}

/// Returns the colours of the model's images, for a preview.
TextureColours ScanStage::textureColours() const {
  if (!input_->attributes().has(AttributeSet::kTexture)) return {};
  const BuildOptions& options = session_.options();
  const uint64_t image_bytes = session_.plan().image_bytes;
  if (!images_.empty()) return {images_, input_->uvGrid(), image_bytes};
  return {surveyTextures(named_images_, options.textures_folder, image_bytes), input_->uvGrid(), image_bytes};
}

void ScanStage::save(RecordWriter& record) const {
  std::vector<std::string> files, names;
  for (const NamedImage& image : named_images_) {
    files.push_back(image.ply.string());
    names.push_back(image.name);
  }
  record.putTexts(files);
  record.putTexts(names);
  input_->save(record);
}

void ScanStage::load(RecordReader& record, bool is_used_up) {
  const std::vector<std::string> files = record.getTexts(), names = record.getTexts();
  if (files.size() != names.size())
    throw Error(ErrorCode::kFormat,
                "the build's journal has a damaged list of images; build without --resume");
  for (size_t i = 0; i < names.size(); ++i) named_images_.push_back({files[i], names[i]});
  if (!is_used_up) input_ = std::make_unique<PackedInput>(PackedInput::load(session_.files(), record));
}

TextureStage::TextureStage(BuildSession& session, ScanStage& scan)
    : Stage({.name = "textures",
             .entry = BuildEntry::kTextures,
             .used_up_by = BuildEntry::kPacked,
             .files = {StagedTextures::kFile}}),
      session_(session),
      scan_(scan) {}

Stage::Work TextureStage::run() {
  std::vector<TextureImage> images = scan_.takeImages();
  if (images.empty()) images = findImages(session_, scan_.namedImages());
  tiles_.emplace(session_.files().lastingFile(StagedTextures::kFile));
  textures_ = stageTextures(session_.options(), images, session_.facts().uv_grid, *tiles_,
                            session_.plan().image_bytes, session_.progress());
  session_.warn(textures_.warnings);
  tiles_->sync();
  return {textures_.textures.size(), tiles_->size()};
}

void TextureStage::save(RecordWriter& record) const {
  record.put(tiles_->size());
  textures_.save(record);
}

void TextureStage::load(RecordReader& record, bool is_used_up) {
  const auto tile_bytes = record.get<uint64_t>();
  textures_ = StagedTextures::load(record);
  if (!is_used_up) tiles_.emplace(session_.files().lastingFile(StagedTextures::kFile), tile_bytes);
}

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

/// Sorts the triangles. A resumed build continues at the batch that was being read when the last recorded run
/// was written. It dereferences this batch again, but skips the triangles that are already in a run.
void DereferenceStage::sortSoup(const PackedInput& input) {
  DereferencePoint begin;
  uint64_t sorted = 0;  // triangles of the batch that are already in runs
  if (!session_.recorded().sorting.empty()) {
    RecordReader record(session_.recorded().sorting);
    begin = record.get<DereferencePoint>();
    sorter_->restore(record);
    if (sorter_->size() < begin.counts.triangles)
      throw Error(ErrorCode::kFormat, "the build's journal has a damaged sort entry; build without --resume");
    sorted = sorter_->size() - begin.counts.triangles;
  }
  BuildFacts& facts = session_.facts();
  const CellGrid grid(facts.choice.extent);
  sorter_->reserve(input.faceCount());
  std::byte bytes[kMaxSoupBytes];
  const std::span<std::byte> soup(bytes, soupBytes(facts.soup_attributes));
  SortLog log(session_, *sorter_);
  log.beginBatch(begin);
  const auto push = [&](std::span<const SoupTriangle> triangles) {
    const uint64_t pushed = std::min<uint64_t>(sorted, triangles.size());
    sorted -= pushed;
    for (const SoupTriangle& triangle : triangles.subspan(pushed)) {
      storeSoup(triangle, soup);
      sorter_->push(grid.code(triangle), soup);
      log.afterTriangle();
    }
  };
  facts.counts = dereference({.input = input,
                              .lattice = facts.choice.lattice,
                              .memory_bytes = session_.plan().sort_bytes,
                              .threads = session_.plan().threads,
                              .progress = session_.progress(),
                              .from = begin,
                              .on_batch = [&](const DereferencePoint& point) { log.beginBatch(point); }},
                             push);
}

void DereferenceStage::load(RecordReader& record, bool is_used_up) {
  if (is_used_up) return;
  openSorter();
  sorter_->restore(record);
  sorter_->finish();
}

PartitionStage::PartitionStage(BuildSession& session, DereferenceStage& dereference)
    : Stage({.name = "partition",
             .entry = BuildEntry::kPartitioned,
             .used_up_by = BuildEntry::kSimplified,
             .files = {Partition::kLeafFile, BorderTable::kFile}}),
      session_(session),
      dereference_(dereference) {}

Stage::Work PartitionStage::run() {
  const std::unique_ptr<RecordSorter> sorted = dereference_.takeSorted();
  const BuildOptions& options = session_.options();
  const MemoryPlan& plan = session_.plan();
  partition_.emplace(ingest::partition({.sorted = *sorted,
                                        .attributes = session_.facts().soup_attributes,
                                        .triangles_per_node = options.triangles_per_node,
                                        .crease = CreaseAngle(options.crease_angle_deg),
                                        .memory_bytes = plan.sort_bytes,
                                        .threads = plan.threads,
                                        .folder = session_.files(),
                                        .progress = session_.progress()}));
  refuseTooManyLocked(partition_->border.lockedBelowRoot(), options.input);
  return {partition_->triangles, partition_->meshes.size() + partition_->border.temporaryBytes()};
}

void PartitionStage::load(RecordReader& record, bool is_used_up) {
  if (!is_used_up)
    partition_.emplace(Partition::load(session_.files(), session_.facts().soup_attributes, record));
}

PackStage::PackStage(BuildSession& session, const TextureStage& textures, SimplifyStage& simplified)
    : Stage({.name = "pack", .entry = BuildEntry::kPacked, .used_up_by = BuildEntry::kPacked}),
      session_(session),
      textures_(textures),
      simplified_(simplified) {}

ModelSummary PackStage::description() const {
  const BuildFacts& facts = session_.facts();
  ModelSummary summary;
  summary.name = session_.options().output.stem().string();
  summary.lattice = facts.choice.lattice;
  summary.attributes = facts.payloadAttributes();
  summary.triangles = facts.counts.triangles;
  summary.dropped = facts.counts.dropped + facts.dropped_triangles;
  summary.triangles_per_node = session_.options().triangles_per_node;
  return summary;
}

Stage::Work PackStage::run() {
  ModelSummary summary = description();
  store::Writer writer(session_.options().output, session_.store());
  if (summary.attributes.has(AttributeSet::kTexture))
    packTextures(textures_.textures(), session_.facts().uv_grid, textures_.tiles(), writer);
  summary = pack(writer, std::move(summary), simplified_.tree(), session_.progress());
  build_id_ = summary.build_id;
  const uint64_t payloads = summary.payloads;
  session_.setSummary(std::move(summary));
  return {payloads, 0};
}

}  // namespace lode::ingest
