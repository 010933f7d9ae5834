#pragma once

#include <chrono>
#include <cstdint>

/// Limits of the protocol, checked before memory is allocated. docs/protocol.md lists all limits.
namespace lode::proto {

constexpr uint32_t kProtocolVersion = 4;
constexpr uint16_t kDefaultPort = 7400;
constexpr uint32_t kMaxFrameBodyBytes = 256u << 10;  ///< size of any frame's body
constexpr uint32_t kMaxHelloBodyBytes = 4u << 10;    ///< size of a frame's body before Hello is accepted
constexpr uint32_t kMaxChunkBytes = 32u << 10;       ///< raw bytes of a Blob frame
constexpr uint32_t kMaxRequestsPerFrame = 4096;      ///< number of entries of a Requests frame
constexpr uint32_t kMaxOpenRequests = 16384;         ///< number of open requests of a session
constexpr uint32_t kMaxOpenModels = 64;              ///< number of open models of a session
constexpr uint32_t kMaxListedModels = 1024;          ///< number of models of a Models message
constexpr uint32_t kMaxStringBytes = 1024;           ///< length of a string that has no limit of its own
constexpr uint32_t kMaxTokenBytes = 512;
/// Bytes that the server may send before the first Credit.
constexpr uint64_t kInitialWindowBytes = 64u << 10;
constexpr uint64_t kFeatureClose = 1;  ///< feature bit of Hello and Welcome: the peer knows Close and Closed
/// Size of queued answers above which either side stops reading from a connection (back-pressure).
constexpr uint64_t kMaxQueuedAnswerBytes = 64u << 10;

// Defaults of `lodestreamd serve`; each has an option.
constexpr uint32_t kMaxConnections = 10'000;
constexpr uint32_t kMaxConnectionsPerAddress = 256;
constexpr std::chrono::milliseconds kHandshakeDeadline{10'000};  ///< time from accept to Hello, TLS included
constexpr std::chrono::milliseconds kIdleDeadline{120'000};      ///< time between two frames of the client
constexpr std::chrono::milliseconds kWriteDeadline{30'000};      ///< time that a write may block
constexpr std::chrono::milliseconds kDrainDeadline{5'000};  ///< time to finish open requests after GoAway
constexpr std::chrono::milliseconds kHearDeadline{2'000};   ///< time to wait for the Pong after GoAway

}  // namespace lode::proto
