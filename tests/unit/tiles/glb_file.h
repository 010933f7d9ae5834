#pragma once

#include <cstring>
#include <span>
#include <string>
#include <vector>

#include <draco/compression/decode.h>
#include <draco/mesh/mesh.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "common/mesh.h"

namespace lode::test {

/// A GLB, split into its chunks.
struct GlbFile {
  nlohmann::json json;
  std::vector<std::byte> binary;

  std::span<const std::byte> view(size_t number) const {
    const auto& view = json["bufferViews"][number];
    return std::span(binary).subspan(view.value("byteOffset", size_t{0}), view["byteLength"]);
  }
  const nlohmann::json& primitive() const { return json["meshes"][0]["primitives"][0]; }
  const nlohmann::json& accessor(const std::string& attribute) const {
    return json["accessors"][primitive()["attributes"][attribute].get<size_t>()];
  }
  const nlohmann::json& idsInStream() const {
    return primitive()["extensions"]["KHR_draco_mesh_compression"]["attributes"];
  }
};

inline GlbFile parseGlb(std::span<const std::byte> bytes) {
  const auto number = [&](size_t at) {
    uint32_t value = 0;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
  };
  EXPECT_EQ(std::memcmp(bytes.data(), "glTF", 4), 0);
  EXPECT_EQ(number(4), 2u);
  EXPECT_EQ(number(8), bytes.size());
  const uint32_t json_bytes = number(12), binary_bytes = number(20 + json_bytes);
  EXPECT_EQ(json_bytes % 4 + binary_bytes % 4, 0u);
  EXPECT_EQ(28 + json_bytes + binary_bytes, bytes.size());
  const std::string text(reinterpret_cast<const char*>(bytes.data()) + 20, json_bytes);
  const auto binary = bytes.subspan(28 + json_bytes);
  return {nlohmann::json::parse(text), {binary.begin(), binary.end()}};
}

/// Decodes a GLB's stream as viewers do, with Draco's own conversion of quantized values to floats.
class ViewedStream {
 public:
  explicit ViewedStream(const GlbFile& glb) {
    const auto bytes = glb.view(0);
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    auto decoded = draco::Decoder().DecodeMeshFromBuffer(&buffer);
    EXPECT_TRUE(decoded.ok());
    mesh_ = std::move(decoded).value();
  }

  const draco::Mesh& mesh() const { return *mesh_; }
  std::vector<float> floats(uint32_t id, uint32_t vertex) const {
    const draco::PointAttribute* const attribute = mesh_->GetAttributeByUniqueId(id);
    std::vector<float> values(attribute->num_components());
    attribute->GetMappedValue(draco::PointIndex(vertex), values.data());
    return values;
  }

 private:
  std::unique_ptr<draco::Mesh> mesh_;
};

}  // namespace lode::test
