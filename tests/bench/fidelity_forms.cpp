#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <vector>

#include "common/codec/octahedral.h"
#include "server/ingest/simplify/wedge_values.h"
#include "tests/bench/attribute_loss.h"
#include "tests/bench/fidelity_parts.h"
#include "tests/bench/form_collapse.h"

namespace lode::bench {
namespace {

using ingest::WedgeValue;

constexpr size_t kSamples = 200000;  // each way
constexpr int kRuns = 3;             // of which the median counts, the forms in turn
constexpr std::array<size_t, 2> kReductions{4, 10};

/// A part of WedgeValue and how long a unit of it is; weights as in wedge_quadrics.cpp.
struct Channel {
  int part;
  double scale;
};

std::vector<Channel> channelsOf(const FileNode& model) {
  std::vector<Channel> channels;
  const double diagonal = glm::length(glm::dvec3(model.extent));
  const auto add = [&](int first, int count, double scale) {
    for (int i = 0; i < count; ++i) channels.push_back({first + i, diagonal * scale});
  };
  const AttributeSet has = model.mesh.attributes;
  if (has.has(AttributeSet::kNormal)) add(WedgeValue::kNormal, 3, 0.007);
  if (has.has(AttributeSet::kColour)) add(WedgeValue::kColour, 3, 0.03 / 255);
  if (has.has(AttributeSet::kTexture)) add(WedgeValue::kTexture, 2, 0.1 / 65535);
  return channels;
}

/// A vertex a wedge; positions of several wedges are locked, so that seams stay as they are in both forms.
template <size_t K>
FormMesh<K> formMeshOf(const FileNode& model, std::span<const Channel> channels) {
  const ingest::NodeMesh& mesh = model.mesh;
  const ingest::WedgeTable table(mesh.attributes, mesh.wedge_attributes);
  std::vector<uint32_t> wedges(mesh.positions.size());
  for (const uint32_t position : mesh.wedge_position) ++wedges[position];
  FormMesh<K> result;
  result.triangles = mesh.triangles;
  for (uint32_t i = 0; i < mesh.wedge_position.size(); ++i) {
    const uint32_t position = mesh.wedge_position[i];
    Place<K> place{glm::dvec3(unpackPosition(mesh.positions[position])) - 0.5 * glm::dvec3(model.extent), {}};
    const WedgeValue value = table.value(i);
    for (size_t k = 0; k < K; ++k)
      place.values[k] = channels[k].scale * value.parts[static_cast<size_t>(channels[k].part)];
    result.vertices.push_back(place);
    result.locked.push_back(wedges[position] > 1);
  }
  return result;
}

template <size_t K>
ingest::NodeMesh nodeOf(const FileNode& model, const FormMesh<K>& simple, std::span<const Channel> channels) {
  ingest::NodeMesh mesh;
  mesh.attributes = model.mesh.attributes;
  mesh.triangles = simple.triangles;
  ingest::WedgeTable table(mesh.attributes, model.mesh.wedge_attributes);
  const glm::dvec3 extent(model.extent);
  for (uint32_t i = 0; i < simple.vertices.size(); ++i) {
    const Place<K>& place = simple.vertices[i];
    const glm::dvec3 point = glm::clamp(glm::round(place.position + 0.5 * extent), glm::dvec3(0), extent);
    mesh.positions.push_back(packPosition(glm::uvec3(point)));
    mesh.wedge_position.push_back(i);
    WedgeValue value = table.value(i);
    for (size_t k = 0; k < K; ++k)
      value.parts[static_cast<size_t>(channels[k].part)] =
          static_cast<float>(place.values[k] / channels[k].scale);
    table.set(i, value);
    mesh.wedge_attributes.push_back(table.code(i));
  }
  return mesh;
}

double cpuSeconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

struct FormResult {
  std::vector<double> seconds;
  size_t triangles = 0;
  AttributeLoss loss;
};

template <typename Form, size_t K>
void runForm(const FileNode& model, const AttributeField& original, std::span<const Channel> channels,
             size_t target, FormResult& result) {
  FormMesh<K> input = formMeshOf<K>(model, channels);
  const double start = cpuSeconds();
  const FormMesh<K> simple = FormCollapse<Form, K>(std::move(input)).run(target);
  result.seconds.push_back(cpuSeconds() - start);
  if (result.triangles != 0) return;
  result.triangles = simple.triangles.size();
  result.loss = attributeLoss(original, nodeOf<K>(model, simple, channels), kSamples);
}

void print(const char* name, FormResult& result, const FileNode& model) {
  std::sort(result.seconds.begin(), result.seconds.end());
  const AttributeLoss& loss = result.loss;
  std::printf("  %-22s %7zu triangles  %.3f CPU s ", name, result.triangles,
              result.seconds[result.seconds.size() / 2]);
  if (model.mesh.attributes.has(AttributeSet::kColour)) std::printf(" colour %.3g", loss.colour);
  if (model.mesh.attributes.has(AttributeSet::kNormal)) std::printf(" normal %.3g degrees", loss.normal_deg);
  if (model.mesh.attributes.has(AttributeSet::kTexture))
    std::printf(" texture %.3g", loss.texture * model.texture_scale / 65536);
  std::printf(" rms %.3e\n", loss.surface);
}

template <size_t K>
void compare(const FileNode& model, const AttributeField& original, std::span<const Channel> channels) {
  for (const size_t reduction : kReductions) {
    const size_t target = model.mesh.triangles.size() / reduction;
    FormResult hoppe, garland;
    for (int run = 0; run < kRuns; ++run) {
      runForm<GradientForm<K>, K>(model, original, channels, target, hoppe);
      runForm<OneSpaceForm<K>, K>(model, original, channels, target, garland);
    }
    print("Hoppe 1999", hoppe, model);
    print("Garland, Heckbert 1998", garland, model);
  }
}

}  // namespace

void compareForms(std::span<char* const> models) {
  for (const char* path : models) {
    const FileNode model = readNode(path);
    const AttributeField original(model.mesh);
    const std::vector<Channel> channels = channelsOf(model);
    std::printf("%s: %zu triangles, %zu channels\n", path, model.mesh.triangles.size(), channels.size());
    switch (channels.size()) {
      case 2:
        compare<2>(model, original, channels);
        break;
      case 3:
        compare<3>(model, original, channels);
        break;
      case 5:
        compare<5>(model, original, channels);
        break;
      case 6:
        compare<6>(model, original, channels);
        break;
      case 8:
        compare<8>(model, original, channels);
        break;
      default:
        std::printf("  no attributes\n");
    }
  }
}

}  // namespace lode::bench
