#include "server/ingest/build/build_steps.h"

#include <algorithm>
#include <utility>

#include "common/error.h"
#include "server/ingest/build/pack.h"
#include "server/ingest/build/stage_clock.h"
#include "server/ingest/mesh/cell_code.h"
#include "server/store/reader.h"

namespace lode::ingest {
namespace {

constexpr std::string_view kRunsFile = "runs";
constexpr uint64_t kTrianglesBetweenLooks = 1 << 16;  ///< at the clock

constexpr double kRounding = 1.0001;  ///< of an error that is noted as a float

/// Attributes of the payloads: the file's, with computed normals where it has none.
AttributeSet payloadAttributes(AttributeSet file) {
  if (!file.has(AttributeSet::kNormal)) file.bits |= AttributeSet::kNormal | AttributeSet::kComputedNormal;
  return file;
}

void putTexts(RecordWriter& record, const std::vector<std::string>& texts) {
  record.put(static_cast<uint32_t>(texts.size()));
  for (const std::string& text : texts) record.putText(text);
}

std::vector<std::string> getTexts(RecordReader& record) {
  std::vector<std::string> texts;
  for (auto count = record.get<uint32_t>(); count > 0; --count) texts.push_back(record.getText());
  return texts;
}

}  // namespace

BuildSteps::BuildSteps(const BuildOptions& options, const BuildProgress& progress)
    : options_(options),
      progress_(progress),
      plan_(planMemory(options.memory_bytes, options.threads, options.triangles_per_node)),
      identity_(BuildIdentity::of(options)),
      folder_(options.output, options.temporary_folder) {
  std::error_code ignored;
  if (std::filesystem::exists(folder_.journal(), ignored)) resume();
  if (!journal_) begin();
  folder_.keep(false);
}

/// Opens the journal that is there if the build is to go on from it; clears it away otherwise.
void BuildSteps::resume() {
  try {
    journal_.emplace(Journal::open(
        folder_.journal(),
        [this](uint32_t kind, std::span<const std::byte> bytes) { recorded_.add(kind, bytes); }));
  } catch (const Error&) {
    if (options_.resume) throw;
  }
  if (options_.resume && recorded_.identity) {
    const std::string difference = recorded_.identity->difference(identity_);
    if (!difference.empty()) {
      throw Error(ErrorCode::kInput,
                  "cannot resume the build of " + options_.output.string() + ": " + difference);
    }
    if (!recorded_.packed || isPackedAlready()) {
      files_.emplace(folder_.openFiles());
      return;
    }
  }
  journal_.reset();
  if (recorded_.identity) folder_.clear(recorded_.identity->temporary_folder);
  recorded_ = {};
}

void BuildSteps::begin() {
  folder_.keep(false);
  folder_.clear(options_.temporary_folder);
  files_.emplace(folder_.openFiles());
  journal_.emplace(Journal::create(folder_.journal()));
  RecordWriter record;
  identity_.save(record);
  journal_->append(static_cast<uint32_t>(BuildEntry::kBegun), record.bytes());
  folder_.syncFolders();
}

bool BuildSteps::isPackedAlready() {
  try {
    const store::Reader reader(options_.output);
    report_.summary = reader.summary();
    return reader.summary().build_id == recorded_.packed->build_id;
  } catch (const Error&) {
    return false;
  }
}

bool BuildSteps::keep() noexcept {
  const bool is_begun_only = journal_->entries() <= 1;
  folder_.keep(!is_begun_only);
  return !is_begun_only;
}

void BuildSteps::note(BuildEntry kind, const RecordWriter& record) {
  folder_.syncFiles();
  journal_->append(static_cast<uint32_t>(kind), record.bytes());
}

void BuildSteps::noteResumed(const char* stage) {
  if (!recorded_.scanned.empty() && report_.resumed_from.empty()) report_.resumed_from = stage;
}

void BuildSteps::scan() {
  if (!recorded_.scanned.empty()) {
    restoreScan();
    return;
  }
  StageClock clock(report_, "scan");
  surveyImages();
  ScannedModel scanned = ingest::scan(options_, *files_, progress_, report_.warnings);
  facts_.choice = chooseLattice(scanned.input, options_.input);
  facts_.soup_attributes = scanned.input.attributes();
  facts_.uv_grid = scanned.input.uvGrid();
  facts_.dropped = scanned.counts.dropped_faces + scanned.counts.skipped_bad;
  texture_files_ = std::move(scanned.texture_files);
  RecordWriter record;
  record.put(facts_);
  putTexts(record, report_.warnings);
  putTexts(record, texture_files_);
  scanned.input.save(record);
  note(BuildEntry::kScanned, record);
  input_ = std::make_unique<PackedInput>(std::move(scanned.input));
  clock.finish(input_->vertexCount() + input_->faceCount(), input_->temporaryBytes());
}

void BuildSteps::restoreScan() {
  RecordReader record(recorded_.scanned);
  facts_ = record.get<Facts>();
  report_.warnings = getTexts(record);
  texture_files_ = getTexts(record);
  if (recorded_.dereferenced.empty() && recorded_.partitioned.empty()) {
    input_ = std::make_unique<PackedInput>(PackedInput::load(*files_, record));
  }
}

void BuildSteps::textures() {
  textures_.grid = facts_.uv_grid;
  const TemporaryFile file = files_->lastingFile(StagedTextures::kFile);
  if (!recorded_.textures.empty()) {
    RecordReader record(recorded_.textures);
    report_.warnings = getTexts(record);
    const auto tile_bytes = record.get<uint64_t>();
    textures_ = StagedTextures::load(record);
    if (!recorded_.packed) tiles_.emplace(file, tile_bytes);
  } else {
    tiles_.emplace(file);
    if (!texture_files_.empty()) readImages();
  }
  refuseWarnings();
}

/// So early that what is wrong with the images as a whole costs no time.
void BuildSteps::surveyImages() {
  const PlyReader reader(options_.input, {.skip_bad = options_.skip_bad});
  if (reader.attributes().has(AttributeSet::kTexture))
    images_ = surveyTextures(options_.input, reader.header().texture_files, plan_.image_bytes);
  refuseLargeImages();
}

bool BuildSteps::lacksMemory() const noexcept {
  return std::ranges::any_of(images_, &TextureImage::needs_memory);
}

/// To leave one out would make the store follow from --memory.
void BuildSteps::refuseLargeImages() const {
  for (const TextureImage& image : images_) {
    if (image.needs_memory)
      throw Error(ErrorCode::kLimit, textureInWords(options_.input, image.name) + " " + image.problem);
  }
}

void BuildSteps::readImages() {
  if (!facts_.soup_attributes.has(AttributeSet::kTexture)) {
    report_.warnings.push_back(options_.input.string() +
                               ": it names texture files, but has no texture coordinates; they are left out");
    return;
  }
  noteResumed("textures");
  StageClock clock(report_, "textures");
  if (images_.empty()) images_ = surveyTextures(options_.input, texture_files_, plan_.image_bytes);
  refuseLargeImages();
  textures_ = stageTextures(options_, images_, facts_.uv_grid, *tiles_, plan_.image_bytes, progress_,
                            report_.warnings);
  giveBackFreedMemory();
  tiles_->sync();
  RecordWriter record;
  putTexts(record, report_.warnings);
  record.put(tiles_->size());
  textures_.save(record);
  note(BuildEntry::kTextures, record);
  clock.finish(textures_.textures.size(), tiles_->size());
}

void BuildSteps::refuseWarnings() const {
  if (options_.strict && !report_.warnings.empty())
    throw Error(ErrorCode::kInput, report_.warnings.front() + " (--strict: warnings are errors)");
}

void BuildSteps::dereference() {
  if (!recorded_.partitioned.empty()) return;
  sorter_ = std::make_unique<RecordSorter>(soupBytes(facts_.soup_attributes), plan_.sort_bytes,
                                           files_->lastingFile(kRunsFile), plan_.threads);
  if (!recorded_.dereferenced.empty()) {
    RecordReader record(recorded_.dereferenced);
    counts_ = record.get<DereferenceCounts>();
    sorter_->restore(record);
    sorter_->finish();
    return warnOfLost();
  }
  noteResumed("dereference");
  StageClock clock(report_, "dereference");
  sortSoup();
  if (counts_.triangles == 0) {
    throw Error(ErrorCode::kInput,
                options_.input.string() + ": no face has three distinct corners; check the file");
  }
  sorter_->finish([this](uint64_t done, uint64_t total) {
    if (progress_) progress_("sort", static_cast<double>(done) / static_cast<double>(total), done, total);
  });
  input_.reset();
  giveBackFreedMemory();
  if (sorter_->runCount() > 0) {
    RecordWriter record;
    record.put(counts_);
    sorter_->save(record);
    note(BuildEntry::kDereferenced, record);
    folder_.removeFilesBut({StagedTextures::kFile, kRunsFile});
  }
  clock.finish(counts_.triangles, sorter_->temporaryBytes());
  warnOfLost();
}

void BuildSteps::warnOfLost() {
  if (counts_.lost == 0) return;
  report_.warnings.push_back(options_.input.string() + ": " +
                             inWordsOfLost(counts_.lost, facts_.choice.lattice.step));
  refuseWarnings();
}

/// Pushes the soup to the sorter, and notes runs that are written. What a killed build had in runs is not
/// pushed again, but its triangles in the batch that it was at are looked up again.
void BuildSteps::sortSoup() {
  DereferencePoint batch;
  uint64_t known = 0;
  if (!recorded_.sorting.empty()) {
    RecordReader record(recorded_.sorting);
    batch = record.get<DereferencePoint>();
    sorter_->restore(record);
    if (sorter_->size() < batch.counts.triangles)
      throw Error(ErrorCode::kFormat,
                  "the journal of a build names no point of a sort; build without --resume");
    known = sorter_->size() - batch.counts.triangles;
  }
  const CellGrid grid(facts_.choice.extent);
  sorter_->reserve(input_->faceCount());
  std::byte bytes[kMaxSoupBytes];
  const std::span<std::byte> soup(bytes, soupBytes(facts_.soup_attributes));
  CheckpointClock clock(CheckpointClock::Clock::now());
  size_t runs = sorter_->runCount();
  auto last_run = CheckpointClock::Clock::now();
  const auto noteRuns = [&] {
    runs = sorter_->runCount();
    const auto began = last_run = CheckpointClock::Clock::now();
    if (!clock.isDue(began)) return;
    RecordWriter record;
    record.put(batch);
    sorter_->save(record);
    note(BuildEntry::kSorting, record);
    clock.noted(began, CheckpointClock::Clock::now());
  };
  counts_ = ingest::dereference(
      *input_, facts_.choice.lattice, plan_.sort_bytes,
      [&](const SoupTriangle& triangle) {
        if (known > 0) {
          --known;
          return;
        }
        storeSoup(triangle, soup);
        sorter_->push(grid.code(triangle), soup);
        // Where memory is ample, the first run may be long in coming.
        if (sorter_->size() % kTrianglesBetweenLooks == 0 &&
            CheckpointClock::Clock::now() - last_run > CheckpointClock::kLatest)
          sorter_->spill();
        if (sorter_->runCount() != runs) noteRuns();
      },
      progress_, batch, [&](const DereferencePoint& point) { batch = point; });
}

void BuildSteps::partition() {
  if (!recorded_.partitioned.empty()) {
    RecordReader record(recorded_.partitioned);
    counts_ = record.get<DereferenceCounts>();
    warnOfLost();
    if (!recorded_.is_simplified) parts_.emplace(Partition::load(*files_, facts_.soup_attributes, record));
    return;
  }
  noteResumed("partition");
  StageClock clock(report_, "partition");
  parts_.emplace(ingest::partition(*sorter_, facts_.soup_attributes, options_.triangles_per_node,
                                   CreaseAngle(options_.crease_angle_deg), plan_.sort_bytes, plan_.threads,
                                   *files_, progress_));
  sorter_.reset();
  giveBackFreedMemory();
  RecordWriter record;
  record.put(counts_);
  parts_->save(record);
  note(BuildEntry::kPartitioned, record);
  folder_.removeFilesBut({StagedTextures::kFile, Partition::kLeafFile, BorderTable::kFile});
  clock.finish(parts_->triangles, parts_->meshes.size() + parts_->border.temporaryBytes());
}

NodeBuilder::Settings BuildSteps::settings() const {
  return {facts_.choice.lattice,
          facts_.choice.extent,
          payloadAttributes(facts_.soup_attributes),
          options_.triangles_per_node,
          options_.simplifier,
          static_cast<float>(kRounding * counts_.snap_error_steps),
          CreaseAngle(options_.crease_angle_deg)};
}

void BuildSteps::simplify() {
  if (recorded_.packed) return;
  const uint64_t payload_bytes = recorded_.finished.payload_bytes;
  nodes_.emplace(files_->file(NodeSpool::kFile));
  if (recorded_.is_simplified) {
    payloads_.emplace(*files_, payload_bytes);
    for (const FinishedNode& finished : std::exchange(recorded_.finished, {}).nodes)
      nodes_->append(finished.node, finished.payloads);
    return;
  }
  noteResumed("simplify");
  if (parts_->leaves.size() > 1 && options_.memory_bytes < plan_.minimum_bytes) {
    report_.warnings.push_back("--memory is less than " + std::to_string(plan_.minimum_bytes) +
                               " bytes, which " + std::to_string(options_.triangles_per_node) +
                               " triangles a node take; the build may use more");
    refuseWarnings();
  }
  StageClock clock(report_, "simplify");
  if (recorded_.finished.nodes.empty()) {
    payloads_.emplace(*files_);
  } else {
    payloads_.emplace(*files_, payload_bytes);
  }
  {
    SimplifyLog log(*files_, *payloads_, std::move(recorded_.finished),
                    [this](std::span<const std::byte> entry) {
                      journal_->append(static_cast<uint32_t>(BuildEntry::kNodes), entry);
                    });
    folder_.syncFiles();
    ingest::simplify(settings(), *parts_, *payloads_, log, *nodes_, {plan_.threads, plan_.node_bytes},
                     progress_);
  }
  parts_.reset();
  note(BuildEntry::kSimplified, {});
  giveBackFreedMemory();
  folder_.removeFilesBut({StagedTextures::kFile, PayloadSpool::kFile, NodeSpool::kFile});
  clock.finish(nodes_->size(), payloads_->size());
}

ModelSummary BuildSteps::summary() const {
  ModelSummary summary;
  summary.name = options_.output.stem().string();
  summary.lattice = facts_.choice.lattice;
  summary.attributes = settings().attributes;
  summary.triangles = counts_.triangles;
  summary.dropped = counts_.dropped + facts_.dropped;
  summary.triangles_per_node = options_.triangles_per_node;
  return summary;
}

void BuildSteps::pack() {
  if (recorded_.packed) return;
  noteResumed("pack");
  StageClock clock(report_, "pack");
  ModelSummary described = summary();
  store::Writer writer(options_.output, folder_.store());
  if (described.attributes.has(AttributeSet::kTexture)) packTextures(textures_, *tiles_, writer);
  report_.summary = ingest::pack(writer, std::move(described), *nodes_, *payloads_, progress_);
  RecordWriter record;
  record.put(PackedStore{report_.summary.build_id, report_.summary.bytes});
  note(BuildEntry::kPacked, record);
  clock.finish(report_.summary.payloads, 0);
}

}  // namespace lode::ingest
