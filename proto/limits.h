#pragma once

#include <cstdint>

/// Every limit of the wire, checked before memory is taken. docs/protocol.md lists them.
namespace lode::proto {

constexpr uint32_t kProtocolVersion = 1;
constexpr uint16_t kDefaultPort = 7400;
constexpr uint32_t kMaxFrameBodyBytes = 256u << 10;  ///< of any frame
constexpr uint32_t kMaxHelloBodyBytes = 4u << 10;    ///< of any frame that a server takes before Hello
constexpr uint32_t kMaxChunkBytes = 32u << 10;       ///< raw bytes of a Blob frame
constexpr uint32_t kMaxWishesPerFrame = 4096;        ///< entries of a Wishes frame
constexpr uint32_t kMaxOpenWishes = 16384;           ///< of a session at one time
constexpr uint32_t kMaxOpenModels = 64;              ///< of a session at one time
constexpr uint32_t kMaxListedModels = 1024;          ///< of a List answer
constexpr uint32_t kMaxStringBytes = 1024;           ///< of any string in a message
constexpr uint32_t kMaxTokenBytes = 512;
constexpr uint64_t kInitialWindowBytes = 64u << 10;  ///< granted before the first Credit frame
constexpr uint64_t kFixedWindowBytes = 1u << 20;  ///< what a client grants ahead until it measures the link

}  // namespace lode::proto
