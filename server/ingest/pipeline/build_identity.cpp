#include "server/ingest/pipeline/build_identity.h"

#include <algorithm>
#include <cstdio>
#include <span>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <link.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/codec/blob.h"
#include "common/codec/texture_set.h"
#include "common/error.h"
#include "common/io/file_io.h"
#include "common/io/texture_finder.h"
#include "common/printable.h"
#include "server/ingest/ply/ply_header.h"

namespace lode::ingest {
namespace {

constexpr uint64_t kEndBytes = 256 << 10;  ///< bytes hashed at the start of a file, and as many at its end
constexpr uint64_t kSamples = 64, kSampleBytes = 4096;

void append(int file, uint64_t offset, uint64_t bytes, std::vector<std::byte>& to) {
  const size_t before = to.size();
  to.resize(before + bytes);
  to.resize(before + readAt(file, offset, std::span(to).subspan(before)).value_or(0));
}

uint64_t hashContent(int file, uint64_t bytes) {
  std::vector<std::byte> taken;
  append(file, 0, std::min(bytes, kEndBytes), taken);
  append(file, bytes - std::min(bytes, kEndBytes), std::min(bytes, kEndBytes), taken);
  for (uint64_t i = 0; i < kSamples; ++i) append(file, bytes / kSamples * i, kSampleBytes, taken);
  return checksum(taken);
}

/// Computes fingerprints of the images that a model names. Returns an empty list if the header cannot be read
/// or names too many images, because the scan stage reports such errors.
std::vector<BuildIdentity::Texture> texturesOf(const BuildOptions& options) {
  std::vector<BuildIdentity::Texture> textures;
  try {
    for (const std::filesystem::path& input : inputsOf(options)) {
      const PlyHeader header = readPlyHeader(input);
      if (textures.size() + header.texture_files.size() > kMaxTextures) return {};
      TextureFinder finder(input, options.textures_folder);
      for (const std::string& name : header.texture_files) {
        const TextureFile file = finder.find(name);
        textures.push_back({name, file.problem.empty() ? fingerprint(file.path) : FileFingerprint()});
      }
    }
  } catch (const Error&) {
    textures.clear();
  }
  return textures;
}

void saveFile(RecordWriter& record, const FileFingerprint& file) {
  record.putText(file.path);
  record.put(file.bytes);
  record.put(file.modified_ns);
  record.put(file.content);
}

FileFingerprint loadFile(RecordReader& record) {
  FileFingerprint file;
  file.path = record.getText();
  file.bytes = record.get<uint64_t>();
  file.modified_ns = record.get<int64_t>();
  file.content = record.get<uint64_t>();
  return file;
}

template <class Value>
void loadOption(RecordReader& record, Value& value) {
  value = record.get<Value>();
}
void loadOption(RecordReader& record, bool& value) { value = record.get<uint8_t>() != 0; }

std::string asGiven(const std::string& name, bool value) { return value ? name : "no " + name; }
std::string asGiven(const std::string& name, uint32_t value) { return name + " " + std::to_string(value); }
std::string asGiven(const std::string& name, Simplifier value) {
  return name + " " + std::string(nameOf(value));
}
std::string asGiven(const std::string& name, float value) {
  char text[32];
  std::snprintf(text, sizeof text, " %g", static_cast<double>(value));
  return name + text;
}

/// Finds the first option that differs between `then` and `now`. Returns the option with its value in `then`,
/// as written on the command line, or an empty string if all options are equal.
std::string changedOption(const ResultOptions& then, const ResultOptions& now) {
  std::string changed;
  forEachResultOption([&](const auto& option) {
    const auto value = then.*option.member;
    if (changed.empty() && value != now.*option.member) changed = asGiven(option.name, value);
  });
  return changed;
}

}  // namespace

FileFingerprint fingerprint(const std::filesystem::path& path) {
  std::error_code ignored;
  FileFingerprint result{std::filesystem::weakly_canonical(path, ignored).string(), 0, 0, 0};
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return result;
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return result;
  result.bytes = static_cast<uint64_t>(status.st_size);
  result.modified_ns = int64_t{status.st_mtim.tv_sec} * 1'000'000'000 + status.st_mtim.tv_nsec;
  result.content = hashContent(file, result.bytes);
  ::close(file);
  return result;
}

uint64_t programContent() {
  std::vector<uint64_t> contents{fingerprint("/proc/self/exe").content};
  const auto add = [](dl_phdr_info* info, size_t, void* all) {
    const std::string name = std::filesystem::path(info->dlpi_name).filename().string();
    if (name.starts_with("libdraco.") || name.starts_with("libm."))
      static_cast<std::vector<uint64_t>*>(all)->push_back(fingerprint(info->dlpi_name).content);
    return 0;
  };
  ::dl_iterate_phdr(add, &contents);
  return checksum(std::as_bytes(std::span(contents)));
}

BuildIdentity BuildIdentity::of(const BuildOptions& options) {
  BuildIdentity identity;
  for (const std::filesystem::path& input : inputsOf(options)) identity.inputs.push_back(fingerprint(input));
  identity.textures = texturesOf(options);
  if (!options.lattice_of.empty()) identity.lattice_of = fingerprint(options.lattice_of);
  identity.program = programContent();
  std::error_code ignored;
  identity.temporary_folder = std::filesystem::weakly_canonical(options.temporary_folder, ignored).string();
  identity.options = options;
  return identity;
}

void BuildIdentity::save(RecordWriter& record) const {
  record.put(static_cast<uint32_t>(inputs.size()));
  for (const FileFingerprint& input : inputs) saveFile(record, input);
  record.put(static_cast<uint32_t>(textures.size()));
  for (const Texture& texture : textures) {
    record.putText(texture.name);
    saveFile(record, texture.image);
  }
  saveFile(record, lattice_of);
  record.put(program);
  record.putText(temporary_folder);
  forEachResultOption([&](const auto& option) { record.put(options.*option.member); });
}

BuildIdentity BuildIdentity::load(RecordReader& record) {
  BuildIdentity identity;
  for (auto count = record.get<uint32_t>(); count > 0; --count) identity.inputs.push_back(loadFile(record));
  for (auto count = record.get<uint32_t>(); count > 0; --count) {
    std::string name = record.getText();
    identity.textures.push_back({std::move(name), loadFile(record)});
  }
  identity.lattice_of = loadFile(record);
  identity.program = record.get<uint64_t>();
  identity.temporary_folder = record.getText();
  forEachResultOption([&](const auto& option) { loadOption(record, identity.options.*option.member); });
  return identity;
}

/// Compares the fingerprints of textures. Assumes that the inputs are equal and therefore name the same
/// textures in the same order.
std::string BuildIdentity::textureDifference(const BuildIdentity& now, const std::string& anew) const {
  for (size_t i = 0; i < std::min(textures.size(), now.textures.size()); ++i) {
    const FileFingerprint &then = textures[i].image, &today = now.textures[i].image;
    if (then == today) continue;
    if (!then.path.empty() && !today.path.empty() && then.path != today.path)
      return "the texture image " + quotedText(textures[i].name, 4096) + " was " +
             quotedText(then.path, 4096) + " when the build began; use the same, or " + anew;
    const char* const what = then.path.empty()    ? " did not exist when the build began; remove it"
                             : today.path.empty() ? " no longer exists; restore it"
                                                  : " has changed since the build began; restore the old one";
    return "the texture image " + quotedText(textures[i].name, 4096) + what + ", or " + anew;
  }
  return {};
}

std::string BuildIdentity::difference(const BuildIdentity& now, const std::string& anew) const {
  const std::string begun = "it began with ", same = "; use the same, or " + anew;
  if (inputs.size() != now.inputs.size()) return begun + std::to_string(inputs.size()) + " inputs" + same;
  for (size_t i = 0; i < inputs.size(); ++i) {
    const FileFingerprint &then = inputs[i], &today = now.inputs[i];
    const std::string the_input = "the input " + then.path;
    if (then.path != today.path) return std::string(begun).append(the_input).append(same);
    if (today.bytes == 0) return the_input + " cannot be read; restore it";
    if (then != today)
      return (inputs.size() > 1 ? the_input : std::string("the input")) + " has changed since it began; " +
             anew;
  }
  if (std::string texture = textureDifference(now, anew); !texture.empty()) return texture;
  if (lattice_of.path != now.lattice_of.path)
    return begun + (lattice_of.path.empty() ? "no --lattice-of" : "--lattice-of " + lattice_of.path) + same;
  if (lattice_of != now.lattice_of) return "the store of --lattice-of has changed since it began; " + anew;
  if (program != now.program) return begun + "another version of lodestreamd; " + anew;
  if (const std::string option = changedOption(options, now.options); !option.empty())
    return begun + option + same;
  if (temporary_folder != now.temporary_folder) return begun + "--tmp " + temporary_folder + same;
  return {};
}

}  // namespace lode::ingest
