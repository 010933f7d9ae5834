#pragma once

#include <chrono>
#include <cstdint>

/// Every limit of the wire, checked before memory is taken. docs/protocol.md lists them.
namespace lode::proto {

constexpr uint32_t kProtocolVersion = 4;
constexpr uint16_t kDefaultPort = 7400;
constexpr uint32_t kMaxFrameBodyBytes = 256u << 10;  ///< of any frame
constexpr uint32_t kMaxHelloBodyBytes = 4u << 10;    ///< of any frame that a server takes before Hello
constexpr uint32_t kMaxChunkBytes = 32u << 10;       ///< raw bytes of a Blob frame
constexpr uint32_t kMaxRequestsPerFrame = 4096;      ///< entries of a Requests frame
constexpr uint32_t kMaxOpenRequests = 16384;         ///< of a session at one time
constexpr uint32_t kMaxOpenModels = 64;              ///< of a session at one time
constexpr uint32_t kMaxListedModels = 1024;          ///< of a List answer
constexpr uint32_t kMaxStringBytes = 1024;           ///< of any string in a message
constexpr uint32_t kMaxTokenBytes = 512;
constexpr uint64_t kInitialWindowBytes = 64u << 10;  ///< granted before the first Credit frame
constexpr uint64_t kFeatureClose = 1;  ///< bit of Hello and Welcome: Close and Closed are understood
constexpr uint64_t kMaxQueuedAnswerBytes = 64u << 10;  ///< above it a server reads nothing more

// What `lodestreamd serve` starts from; each has a flag.
constexpr uint32_t kMaxConnections = 10'000;
constexpr uint32_t kMaxConnectionsPerAddress = 256;
constexpr std::chrono::milliseconds kHandshakeDeadline{10'000};  ///< from the connection to Hello, with TLS
constexpr std::chrono::milliseconds kIdleDeadline{120'000};      ///< from one frame of the client to the next
constexpr std::chrono::milliseconds kWriteDeadline{30'000};  ///< for a write that the client does not take
constexpr std::chrono::milliseconds kDrainDeadline{5'000};   ///< for open requests, after GoAway
constexpr std::chrono::milliseconds kHearDeadline{2'000};    ///< for a client to say that it has heard it

}  // namespace lode::proto
