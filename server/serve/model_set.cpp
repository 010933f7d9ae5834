#include "server/serve/model_set.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

#include <sys/uio.h>
#include <unistd.h>

#include "common/error.h"
#include "common/limits.h"
#include "proto/messages.h"

namespace lode::serve {

namespace {

namespace fs = std::filesystem;

/// Every store named, folders replaced by the stores in them.
std::vector<fs::path> storeFiles(std::span<const fs::path> stores) {
  std::vector<fs::path> files;
  for (const fs::path& path : stores) {
    std::error_code error;
    if (!fs::is_directory(path, error)) {
      files.push_back(path);
      continue;
    }
    const size_t before = files.size();
    for (fs::directory_iterator entry(path, error); !error && entry != fs::directory_iterator();
         entry.increment(error))
      if (entry->path().extension() == ".lode") files.push_back(entry->path());
    if (error) throw Error(ErrorCode::kIo, "cannot list " + path.string() + ": " + error.message());
    if (files.size() == before)
      throw Error(ErrorCode::kUsage,
                  "there is no store (*.lode) in " + path.string() + "; make one with: lodestreamd build");
  }
  std::ranges::sort(files);
  files.erase(std::unique(files.begin(), files.end()), files.end());
  if (files.empty())
    throw Error(ErrorCode::kUsage, "no store to serve; name a .lode file or a folder of them");
  return files;
}

}  // namespace

ModelSet::ModelSet(std::span<const fs::path> stores, std::function<void(std::string_view)> log)
    : log_(std::move(log)) {
  std::vector<std::pair<std::string, fs::path>> named;
  for (const fs::path& file : storeFiles(stores)) named.emplace_back(file.stem().string(), file);
  std::ranges::stable_sort(named, {}, &std::pair<std::string, fs::path>::first);
  if (named.size() > proto::kMaxListedModels)
    throw Error(ErrorCode::kLimit, std::to_string(named.size()) + " stores are more than one server lists; " +
                                       "the limit is " + std::to_string(proto::kMaxListedModels));
  for (size_t i = 0; i < named.size(); ++i) {
    const auto& [name, file] = named[i];
    if (i > 0 && named[i - 1].first == name)
      throw Error(ErrorCode::kUsage, "two stores make a model '" + name +
                                         "': " + named[i - 1].second.string() + " and " + file.string() +
                                         "; rename one");
    add(file);
  }
  proto::Models list;
  for (const OfferedModel& model : offered_) list.models.push_back(model.summary);
  proto::encode(list, 0);  // throws where the answer to List would not fit in a frame
}

void ModelSet::add(const fs::path& file) {
  store::Reader reader(file);
  OfferedModel model;
  model.summary = reader.summary();
  model.summary.name = file.stem().string();
  if (model.summary.name.empty() || model.summary.name.size() > kMaxModelNameBytes ||
      !proto::isWireText(model.summary.name))
    throw Error(ErrorCode::kUsage, "the name of " + file.string() + " cannot name a model: use at most " +
                                       std::to_string(kMaxModelNameBytes) + " bytes of printable UTF-8");
  const uint32_t blobs = reader.blobCount();
  model.blob_bytes.resize(size_t{blobs} + 1);
  for (uint32_t number = 1; number <= blobs; ++number) model.blob_bytes[number] = reader.blob(number).bytes;
  if (const Node* root = reader.find(kRootKey); root != nullptr && !root->rungs.empty())
    model.coarsest_blob = root->rungs.back().payload.number;
  auto trust = std::make_unique<std::atomic<Trust>[]>(size_t{blobs} + 1);
  offered_.push_back(std::move(model));
  sources_.push_back({std::move(reader), std::move(trust)});
}

ReadResult ModelSet::readHot(const Chunk& chunk, std::span<std::byte> into) const noexcept {
  const Source& source = sources_[chunk.model];
  switch (source.trust[chunk.blob].load(std::memory_order_acquire)) {
    case Trust::kUnchecked:
      return ReadResult::kCold;
    case Trust::kDamaged:
      return ReadResult::kDamaged;
    case Trust::kGood:
      break;
  }
  const iovec place{into.data(), chunk.bytes};
  const auto offset = source.reader.blob(chunk.blob).offset + chunk.header.offset_bytes;
  const ssize_t got =
      preadv2(source.reader.fileDescriptor(), &place, 1, static_cast<off_t>(offset), RWF_NOWAIT);
  return got == static_cast<ssize_t>(chunk.bytes) ? ReadResult::kDone : ReadResult::kCold;
}

ReadResult ModelSet::readCold(const Chunk& chunk, std::span<std::byte> into) const noexcept {
  const Source& source = sources_[chunk.model];
  std::atomic<Trust>& trust = source.trust[chunk.blob];
  try {
    if (trust.load(std::memory_order_acquire) == Trust::kUnchecked) {
      const std::vector<std::byte> blob = source.reader.readBlob(chunk.blob);
      std::memcpy(into.data(), blob.data() + chunk.header.offset_bytes, chunk.bytes);
      trust.store(Trust::kGood, std::memory_order_release);
      return ReadResult::kDone;
    }
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kIo) return report(chunk, ReadResult::kFailed, error.what());
    trust.store(Trust::kDamaged, std::memory_order_release);
    return report(chunk, ReadResult::kDamaged, error.what());
  } catch (const std::exception& error) {
    return report(chunk, ReadResult::kFailed, error.what());
  }
  const uint64_t offset = source.reader.blob(chunk.blob).offset + chunk.header.offset_bytes;
  uint32_t done = 0;
  while (done < chunk.bytes) {
    const ssize_t got = pread(source.reader.fileDescriptor(), into.data() + done, chunk.bytes - done,
                              static_cast<off_t>(offset + done));
    if (got == 0) return report(chunk, ReadResult::kDamaged, "the file is shorter than it was");
    if (got < 0 && errno != EINTR) return report(chunk, ReadResult::kFailed, std::strerror(errno));
    if (got > 0) done += static_cast<uint32_t>(got);
  }
  return ReadResult::kDone;
}

ReadResult ModelSet::report(const Chunk& chunk, ReadResult result, std::string_view why) const noexcept {
  try {
    log_("blob " + std::to_string(chunk.blob) + " of " + sources_[chunk.model].reader.path().string() + ": " +
         std::string(why));
  } catch (const std::exception&) {  // the operator's log is full or gone: serving goes on
  }
  return result;
}

}  // namespace lode::serve
