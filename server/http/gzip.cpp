#include "server/http/gzip.h"

#include <limits>

#include <zlib.h>

#include "common/error.h"

namespace lode::http {

namespace {

constexpr int kWindowBitsOfGzip = 15 + 16;  ///< the largest window; 16 selects gzip's header
constexpr int kMemoryLevel = 8;             ///< zlib's default

}  // namespace

std::vector<std::byte> gzip(std::span<const std::byte> bytes, int level) {
  z_stream stream{};
  const auto fail = [] { throw Error(ErrorCode::kInternal, "zlib cannot compress a response"); };
  if (bytes.size() > std::numeric_limits<uInt>::max()) fail();
  if (deflateInit2(&stream, level, Z_DEFLATED, kWindowBitsOfGzip, kMemoryLevel, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::bad_alloc();
  std::vector<std::byte> packed;
  try {
    packed.resize(deflateBound(&stream, static_cast<uLong>(bytes.size())));
  } catch (...) {
    deflateEnd(&stream);
    throw;
  }
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  const int result = deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  if (result != Z_STREAM_END) fail();
  packed.shrink_to_fit();
  return packed;
}

}  // namespace lode::http
