#include "server/ingest/inspect/trial_model.h"

#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "common/io/atomic_file.h"

namespace lode::ingest {
namespace {

class TrialWriter {
 public:
  TrialWriter(const std::filesystem::path& input, const std::filesystem::path& output)
      : reader_(input, {.skip_bad = true}), file_(output), attributes_(reader_.attributes()) {}

  TrialModel write(uint64_t model_faces, uint64_t faces, uint64_t stretches) {
    const bool is_whole = faces >= model_faces;
    period_ = is_whole ? std::max<uint64_t>(1, model_faces) : model_faces / stretches;
    const uint64_t length = is_whole ? period_ : faces / stretches;
    first_ = (period_ - length) / 2;
    end_ = first_ + length;
    reader_.read({}, [&](const PlyFaces& batch) { takeFaces(batch); });
    used_ = faces_.corners;
    std::sort(used_.begin(), used_.end());
    used_.erase(std::unique(used_.begin(), used_.end()), used_.end());
    putText(header());
    reader_.read([&](uint64_t first, std::span<const PlyVertex> rows) { putUsed(first, rows); }, {});
    putFaces();
    file_.commit();
    return {used_.size(), faces_.corner_counts.size()};
  }

 private:
  bool ofCorners() const { return reader_.faceAttributes().has(AttributeSet::kTexture); }

  void takeFaces(const PlyFaces& batch) {
    size_t corner = 0;
    for (size_t i = 0; i < batch.corner_counts.size(); ++i, ++seen_) {
      const size_t begin = corner;
      corner += batch.corner_counts[i];
      if (seen_ % period_ < first_ || seen_ % period_ >= end_) continue;
      faces_.corner_counts.push_back(batch.corner_counts[i]);
      faces_.corners.insert(faces_.corners.end(), batch.corners.begin() + static_cast<ptrdiff_t>(begin),
                            batch.corners.begin() + static_cast<ptrdiff_t>(corner));
      if (!batch.texture.empty())
        faces_.texture.insert(faces_.texture.end(), batch.texture.begin() + static_cast<ptrdiff_t>(begin),
                              batch.texture.begin() + static_cast<ptrdiff_t>(corner));
      if (!batch.materials.empty()) faces_.materials.push_back(batch.materials[i]);
      if (!batch.colours.empty()) faces_.colours.push_back(batch.colours[i]);
    }
  }

  bool ofFaces() const { return reader_.faceAttributes().has(AttributeSet::kColour); }

  std::string colourProperties() const {
    std::string text;
    if (attributes_.has(AttributeSet::kColour))
      text += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    if (attributes_.has(AttributeSet::kAlpha)) text += "property uchar alpha\n";
    return text;
  }
  void putColour(glm::u8vec4 colour) {
    if (attributes_.has(AttributeSet::kColour)) put(glm::u8vec3(colour));
    if (attributes_.has(AttributeSet::kAlpha)) put(colour.a);
  }

  std::string header() const {
    std::string text = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                       std::to_string(used_.size()) +
                       "\nproperty double x\nproperty double y\nproperty double z\n";
    if (attributes_.has(AttributeSet::kNormal))
      text += "property float nx\nproperty float ny\nproperty float nz\n";
    if (!ofFaces()) text += colourProperties();
    if (attributes_.has(AttributeSet::kTexture) && !ofCorners())
      text += "property float s\nproperty float t\n";
    text += "element face " + std::to_string(faces_.corner_counts.size()) +
            "\nproperty list uint uint vertex_indices\n";
    if (ofCorners()) text += "property list uint float texcoord\n";
    if (attributes_.has(AttributeSet::kMaterial)) text += "property int texnumber\n";
    if (ofFaces()) text += colourProperties();
    return text + "end_header\n";
  }

  void putText(const std::string& text) { file_.write(std::as_bytes(std::span(text))); }
  template <class T>
  void put(const T& value) {
    file_.write(std::as_bytes(std::span(&value, 1)));
  }

  void putUsed(uint64_t first, std::span<const PlyVertex> rows) {
    auto next = std::lower_bound(used_.begin(), used_.end(), first);
    for (; next != used_.end() && *next < first + rows.size(); ++next) {
      const PlyVertex& vertex = rows[*next - first];
      put(vertex.position);
      if (attributes_.has(AttributeSet::kNormal)) put(vertex.normal);
      if (!ofFaces()) putColour(vertex.colour);
      if (attributes_.has(AttributeSet::kTexture) && !ofCorners()) put(vertex.texture);
    }
  }

  void putFaces() {
    size_t corner = 0;
    for (size_t i = 0; i < faces_.corner_counts.size(); ++i) {
      const uint32_t corners = faces_.corner_counts[i];
      put(corners);
      for (size_t c = corner; c < corner + corners; ++c) {
        const auto at = std::lower_bound(used_.begin(), used_.end(), faces_.corners[c]);
        put(static_cast<uint32_t>(at - used_.begin()));
      }
      if (ofCorners()) {
        put(uint32_t{2} * corners);
        for (size_t c = corner; c < corner + corners; ++c) put(faces_.texture[c]);
      }
      if (attributes_.has(AttributeSet::kMaterial)) put(int32_t{faces_.materials[i]});
      if (ofFaces()) putColour(faces_.colours[i]);
      corner += corners;
    }
  }

  PlyReader reader_;
  AtomicFile file_;
  const AttributeSet attributes_;
  uint64_t period_ = 1;           ///< the file has one stretch in every `period_` faces
  uint64_t first_ = 0, end_ = 0;  ///< range of the stretch's faces within each period
  uint64_t seen_ = 0;
  PlyFaces faces_;              ///< faces of the stretches
  std::vector<uint64_t> used_;  ///< indices of the vertices that faces_ uses, sorted
};

}  // namespace

TrialModel writeTrialModel(const std::filesystem::path& input, uint64_t model_faces, uint64_t faces,
                           uint64_t stretches, const std::filesystem::path& output) {
  return TrialWriter(input, output).write(model_faces, faces, stretches);
}

}  // namespace lode::ingest
