#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <type_traits>

#include "common/error.h"
#include "server/ingest/ply/ply_body.h"

namespace lode::ingest {
namespace {

template <class T>
T load(const char* from, bool swap) noexcept {
  std::array<char, sizeof(T)> bytes;
  std::memcpy(bytes.data(), from, sizeof(T));
  if (swap) std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<T>(bytes);
}

/// Converts one property of many rows. @return false if a value is NaN, infinite or out of float's range.
template <class T, bool kSwap, class Store>
bool convertColumn(const char* from, size_t stride, std::span<PlyVertex> rows, Store store) {
  bool finite = true;
  for (PlyVertex& row : rows) {
    const T value = load<T>(from, kSwap);
    from += stride;
    if constexpr (std::is_floating_point_v<T>) {
      finite = finite && std::fabs(value) <= static_cast<T>(std::numeric_limits<float>::max());
    }
    store(row, value);
  }
  return finite;
}

/// Converts one field of a batch of rows. @return false if makeVertex() must check the rows one by one.
template <class T, bool kSwap>
bool convertField(VertexField field, const char* from, size_t stride, std::span<PlyVertex> rows) {
  using enum VertexField;
  const auto convert = [&](auto store) { return convertColumn<T, kSwap>(from, stride, rows, store); };
  if (field < kNx) {
    const int i = static_cast<int>(field);
    return convert([i](PlyVertex& row, T value) { row.position[i] = static_cast<double>(value); });
  }
  if (field < kRed) {
    const int i = static_cast<int>(field) - static_cast<int>(kNx);
    return convert([i](PlyVertex& row, T value) { row.normal[i] = static_cast<float>(value); });
  }
  if (field < kS) {
    const int i = static_cast<int>(field) - static_cast<int>(kRed);
    bool fits = true;
    const bool finite = convert([&fits, i](PlyVertex& row, T value) {
      fits = fits && isColour(value);
      row.colour[i] = colourByte(value);
    });
    return finite && fits;
  }
  const int i = static_cast<int>(field) - static_cast<int>(kS);
  return convert([i](PlyVertex& row, T value) { row.texture[i] = static_cast<float>(value); });
}

constexpr uint64_t kRowsAtFirst = 64;  ///< number of first faces read one by one, so that reports name them

class BinaryBody final : public PlyBody {
 public:
  BinaryBody(PlyInput& input, bool swap, PlyReadOptions options) : PlyBody(input, options), swap_(swap) {}

  void readVertices(const VertexPlan& plan, PlyVertexBatch& batch) override {
    element_ = plan.element;
    row_ = 0;
    while (row_ < element_->count) {
      row_offset_ = input_.offset();
      if (plan.row_bytes > 0) {
        readVertexColumns(plan, batch);
      } else {
        readVertexRow(plan, batch);
      }
    }
    batch.flush();
  }

  void readFaces(const FacePlan& plan, PlyFaceBatch& batch) override {
    element_ = plan.element;
    for (row_ = 0; row_ < element_->count;) {
      row_offset_ = input_.offset();
      if (plan.strips) {
        readStripRow(plan, batch);
      } else if (const uint64_t rows = row_ < kRowsAtFirst ? 0 : takeEmptyRows(*element_); rows > 0) {
        addEmptyFaces(rows, batch);
        row_ += rows;
        continue;
      } else {
        readFaceRow(plan, batch);
      }
      ++row_;
    }
    batch.flush();
  }

  void skip(const PlyElement& element) override {
    element_ = &element;
    row_ = 0;
    row_offset_ = input_.offset();
    const bool fixed = std::none_of(element.properties.begin(), element.properties.end(),
                                    [](const PlyProperty& property) { return property.is_list; });
    if (fixed) {
      const uint64_t row_bytes = leastRowBytes(element);
      if (row_bytes > 0 && element.count > input_.remaining() / row_bytes) failTruncated();
      input_.seek(input_.offset() + element.count * row_bytes);
      return;
    }
    for (; row_ < element.count; ++row_) {
      row_offset_ = input_.offset();
      row_ += takeEmptyRows(element);
      if (row_ == element.count) break;
      for (const PlyProperty& property : element.properties) skipProperty(property);
    }
  }

  PlyPlace place() const noexcept override { return {input_.offset(), 0}; }
  void goTo(PlyPlace place) override { input_.seek(place.offset); }

  uint64_t leastRowBytes(const PlyElement& element) const noexcept override {
    uint64_t row_bytes = 0;
    for (const PlyProperty& property : element.properties) {
      row_bytes += plyTypeBytes(property.is_list ? property.count_type : property.type);
    }
    return row_bytes;
  }

 private:
  std::string where() const override { return "byte " + std::to_string(row_offset_); }

  /// Consumes and returns the next n bytes.
  const char* take(size_t n) {
    if (!input_.fill(n)) failTruncated();
    const char* data = input_.data();
    input_.consume(n);
    return data;
  }

  uint64_t takeListCount(const PlyProperty& list) {
    const char* from = take(plyTypeBytes(list.count_type));
    const int64_t count = withPlyType(list.count_type, [&]<class T>(std::type_identity<T>) {
      return static_cast<int64_t>(load<T>(from, swap_));
    });
    if (count < 0) {
      fail("list " + list.name + " has " + std::to_string(count) + " items",
           "the file is damaged; export it again");
    }
    const uint64_t items = static_cast<uint64_t>(count);
    if (items * plyTypeBytes(list.type) > input_.remaining()) failTruncated();
    return items;
  }

  /// Consumes a run of rows that each consist of one empty list, as fast as they can be read. Consumes
  /// nothing if the run is short.
  /// @return the number of rows consumed.
  uint64_t takeEmptyRows(const PlyElement& element) {
    constexpr size_t kStep = 64;
    constexpr std::array<char, kStep> kZeros{};
    if (element.properties.size() != 1 || !element.properties[0].is_list || !input_.fill(kStep)) return 0;
    size_t zeros = 0;
    while (zeros + kStep <= input_.available() &&
           std::memcmp(input_.data() + zeros, kZeros.data(), kStep) == 0)
      zeros += kStep;
    const size_t row_bytes = plyTypeBytes(element.properties[0].count_type);
    const uint64_t rows = std::min<uint64_t>(zeros / row_bytes, element.count - row_);
    input_.consume(static_cast<size_t>(rows) * row_bytes);
    return rows;
  }

  double loadDouble(PlyType type, const char* from) const noexcept {
    return withPlyType(
        type, [&]<class T>(std::type_identity<T>) { return static_cast<double>(load<T>(from, swap_)); });
  }

  double takeDouble(PlyType type) { return loadDouble(type, take(plyTypeBytes(type))); }

  template <class Item>
  void takeItems(const PlyProperty& list, uint64_t count, std::vector<Item>& items) {
    const size_t size = static_cast<size_t>(count);
    const char* from = take(size * plyTypeBytes(list.type));
    items.resize(size);
    withPlyType(list.type, [&]<class T>(std::type_identity<T>) {
      for (size_t i = 0; i < size; ++i) items[i] = static_cast<Item>(load<T>(from + i * sizeof(T), swap_));
    });
  }

  void skipProperty(const PlyProperty& property) {
    const uint64_t bytes = (property.is_list ? takeListCount(property) : 1) * plyTypeBytes(property.type);
    if (bytes > input_.remaining()) failTruncated();
    input_.seek(input_.offset() + bytes);
  }

  void readVertexColumns(const VertexPlan& plan, PlyVertexBatch& batch) {
    if (!input_.fill(plan.row_bytes)) failTruncated();
    const uint64_t whole_rows = input_.available() / plan.row_bytes;
    const std::span<PlyVertex> room = batch.room();
    const std::span<PlyVertex> rows = room.first(
        static_cast<size_t>(std::min({uint64_t{room.size()}, whole_rows, element_->count - row_})));
    std::fill(rows.begin(), rows.end(), PlyVertex{});
    bool sound = true;
    for (const VertexField field : plan.fields) {
      if (field == VertexField::kNone) continue;
      const size_t i = static_cast<size_t>(field);
      const char* from = input_.data() + plan.offsets[i];
      const bool column_sound = withPlyType(plan.types[i], [&]<class T>(std::type_identity<T>) {
        return swap_ ? convertField<T, true>(field, from, plan.row_bytes, rows)
                     : convertField<T, false>(field, from, plan.row_bytes, rows);
      });
      sound = sound && column_sound;
    }
    if (!sound) readVertexRowsOneByOne(plan, batch, rows);
    input_.consume(rows.size() * plan.row_bytes);
    row_ += rows.size();
    batch.commit(rows.size());
  }

  /// Converts a batch row by row. Slow; used only if a value is NaN, infinite, out of float's range, or not a
  /// colour.
  void readVertexRowsOneByOne(const VertexPlan& plan, PlyVertexBatch& batch, std::span<PlyVertex> rows) {
    const uint64_t first_row = row_;
    VertexValues values{};
    for (size_t i = 0; i < rows.size(); ++i) {
      for (const VertexField field : plan.fields) {
        if (field == VertexField::kNone) continue;
        const size_t f = static_cast<size_t>(field);
        values[f] = loadDouble(plan.types[f], input_.data() + i * plan.row_bytes + plan.offsets[f]);
      }
      row_ = first_row + i;
      row_offset_ = input_.offset() + i * plan.row_bytes;
      handleVertexDefect(makeVertex(plan, values, rows[i]), i, batch);
    }
    row_ = first_row;
  }

  void readVertexRow(const VertexPlan& plan, PlyVertexBatch& batch) {
    VertexValues values{};
    for (size_t i = 0; i < plan.fields.size(); ++i) {
      const PlyProperty& property = element_->properties[i];
      if (plan.fields[i] == VertexField::kNone) {
        skipProperty(property);
      } else {
        values[static_cast<size_t>(plan.fields[i])] = takeDouble(property.type);
      }
    }
    handleVertexDefect(makeVertex(plan, values, batch.room().front()), 0, batch);
    ++row_;
    batch.commit(1);
  }

  void readFaceRow(const FacePlan& plan, PlyFaceBatch& batch) {
    beginFace();
    for (size_t i = 0; i < plan.roles.size(); ++i) {
      const PlyProperty& property = element_->properties[i];
      const FaceRole role = plan.roles[i];
      if (role == FaceRole::kSkipped) {
        skipProperty(property);
      } else if (!property.is_list) {
        takeFaceValue(role, property.type, takeDouble(property.type));
      } else {
        const uint64_t count = takeListCount(property);
        checkListLength(property, role, count);
        if (role == FaceRole::kIndices) {
          takeItems(property, count, corners_);
        } else {
          takeItems(property, count, texture_);
        }
      }
    }
    addFace(batch);
  }

  void readStripRow(const FacePlan& plan, PlyFaceBatch& batch) {
    for (size_t i = 0; i < plan.roles.size(); ++i) {
      const PlyProperty& property = element_->properties[i];
      if (plan.roles[i] != FaceRole::kIndices) {
        skipProperty(property);
        continue;
      }
      StripCutter strip(batch);
      for (uint64_t left = takeListCount(property); left > 0;) {
        const uint64_t count = std::min(left, kMaxFaceCorners);
        takeItems(property, count, corners_);
        for (const int64_t index : corners_) addStripIndex(index, strip, batch);
        left -= count;
      }
    }
  }

  bool swap_;
  uint64_t row_offset_ = 0;
};

}  // namespace

std::unique_ptr<PlyBody> makeBinaryBody(PlyInput& input, PlyEncoding encoding, PlyReadOptions options) {
  const bool little = std::endian::native == std::endian::little;
  return std::make_unique<BinaryBody>(input, (encoding == PlyEncoding::kLittleEndian) != little, options);
}

}  // namespace lode::ingest
