// Plays a script of arbitrary events against a server's session: frames of a client, results of the disk,
// room on the link. One byte of the input selects a step; the next bytes are its arguments. The session must
// respect the window and the rules of requests, and must return all memory that it has charged.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/error.h"
#include "server/serve/session/session.h"

namespace {

using namespace lode;
using namespace lode::proto;
using namespace lode::serve;

constexpr uint32_t kBlobs = 40, kFirstLargeBlob = 30;

void require(bool condition) {
  if (!condition) std::abort();
}

class Script {
 public:
  explicit Script(std::span<const std::byte> bytes) : bytes_(bytes) {}
  bool over() const { return bytes_.empty(); }
  uint8_t byte() {
    if (over()) return 0;
    const auto next = std::to_integer<uint8_t>(bytes_.front());
    bytes_ = bytes_.subspan(1);
    return next;
  }
  uint32_t number() { return byte() | uint32_t{byte()} << 8; }
  std::span<const std::byte> bytes(size_t count) {
    const auto taken = bytes_.first(std::min(count, bytes_.size()));
    bytes_ = bytes_.subspan(taken.size());
    return taken;
  }

 private:
  std::span<const std::byte> bytes_;
};

std::shared_ptr<const Catalog> catalogOf(uint8_t build) {
  std::vector<std::shared_ptr<const Model>> models;
  for (const char* name : {"a", "b"}) {
    auto model = std::make_shared<Model>();
    model->summary.name = name;
    model->summary.build_id.bytes[0] = std::byte{build};
    model->summary.lattice.step = 0.5;
    model->summary.root_page = {1, 300, {}};
    model->blob_bytes.assign(kBlobs, 1000);
    std::fill(model->blob_bytes.begin() + kFirstLargeBlob, model->blob_bytes.end(), 200'000);
    model->blob_bytes[0] = 0;
    model->blob_bytes[1] = 300;
    model->coarsest_blob = name[0] == 'a' ? 2 : 0;
    models.push_back(std::move(model));
  }
  return std::make_shared<const Catalog>(std::move(models));
}

/// Runs a script on a session and checks the frames that the session sends.
class Play {
 public:
  Play(Script& script, MemoryBudget& budget)
      : script_(script),
        memory_(budget),
        session_({&served_, &memory_}, {32, std::chrono::seconds(10), std::chrono::seconds(120)}, now_) {}

  void run() {
    while (!script_.over()) step();
    takeControl();
  }

 private:
  template <typename Message>
  void send(const Message& message) {
    const Bytes frame = encode(message, script_.byte());
    const auto header =
        decodeFrameHeader(std::span<const std::byte, kFrameHeaderBytes>(frame.data(), kFrameHeaderBytes));
    session_.receive(header, std::span(frame).subspan(kFrameHeaderBytes), now_);
  }

  void step() {
    switch (script_.byte() % 16) {
      case 0:
        return send(Hello{proto::kProtocolVersion, proto::kProtocolVersion, script_.byte(), "", "fuzz"});
      case 1:
        return send(Open{std::string(1, static_cast<char>('a' + script_.byte() % 3)), {}});
      case 2:
      case 3:
        return request();
      case 4:
        granted_ = std::max(granted_, uint64_t{64u << 10} + 16 * script_.number());
        return send(Credit{granted_});
      case 5:
        return send(Close{script_.byte() % 4u});
      case 6:
        return send(Ping{script_.byte()});
      case 7:
        return send(List{});
      case 8:
      case 9:
      case 10:
        return sendChunk();
      case 11:
        return unpark();
      case 12:
        return takeControl();
      case 13:
        return raw();
      case 14:
        served_.catalog = catalogOf(script_.byte() % 3);
        return session_.servedSetChanged();
      default:
        if (script_.byte() % 8 == 0) session_.drain("stopping", now_);
        now_ += std::chrono::milliseconds(script_.byte());
    }
  }

  void request() {
    Requests requests{script_.byte() % 4u, {}};
    for (unsigned count = script_.byte() % 48; count > 0; --count)
      requests.changes.push_back({static_cast<RequestAction>(script_.byte() % 3),
                                  static_cast<RequestClass>(script_.byte() % 3), script_.byte() % 40u + 1,
                                  script_.byte() % (kBlobs + 2u), static_cast<float>(script_.byte())});
    send(requests);
  }

  /// Sends an arbitrary frame. Notes only the credit that the frame grants.
  void raw() {
    const FrameHeader header{0, script_.byte(), script_.byte(), script_.byte()};
    const auto body = script_.bytes(script_.number() % 512);
    if (header.type == static_cast<uint8_t>(FrameType::kCredit)) try {
        granted_ = std::max(granted_, decode<Credit>(body).granted_bytes);
      } catch (const Error&) {  // NOLINT(bugprone-empty-catch): the frame grants nothing
      }
    session_.receive(header, body, now_);
  }

  void sendChunk() {
    const auto chunk = session_.beginChunk(kMinChunkBytes + script_.number());
    if (!chunk) return;
    require(!session_.beginChunk());
    switch (script_.byte() % 8) {
      case 0:
        return session_.abandonChunk();
      case 1:
        session_.parkChunk();
        return parked_.push_back(*chunk);
      case 2:
        return session_.failChunk(WireError::kDamagedStore, "damaged");
      case 3:
        step();  // another event arrives during the read
        break;
      default:
        break;
    }
    if (session_.finishChunk()) sent(*chunk);
  }

  void sent(const Chunk& chunk) {
    takeControl();  // the control frames that were queued before the chunk
    sent_bytes_ += kBlobChunkHeaderBytes + chunk.bytes;
    require(sent_bytes_ <= granted_);
    require(chunk.bytes > 0 && chunk.bytes <= kMaxChunkBytes);
    require(uint64_t{chunk.header.offset_bytes} + chunk.bytes <= chunk.header.total_bytes);
    if (chunk.header.request == 0) return;
    uint32_t& so_far = sent_[chunk.header.request];
    require(so_far == chunk.header.offset_bytes);
    so_far += chunk.bytes;
    if (chunk.last()) sent_.erase(chunk.header.request);
  }

  void unpark() {
    if (parked_.empty()) return;
    const size_t which = script_.byte() % parked_.size();
    session_.unpark(parked_[which]);
    parked_.erase(parked_.begin() + static_cast<std::ptrdiff_t>(which));
  }

  /// Takes the control frames. The session must send them before it begins another chunk.
  void takeControl() {
    const Bytes control = session_.takeControl();
    for (auto rest = std::span(control); !rest.empty();) {
      const auto header = decodeFrameHeader(rest.first<kFrameHeaderBytes>());
      const auto body = rest.subspan(kFrameHeaderBytes, header.body_bytes);
      if (header.type == static_cast<uint8_t>(FrameType::kCancelled))
        sent_.erase(decode<Cancelled>(body).request);
      if (header.type == static_cast<uint8_t>(FrameType::kError))
        sent_.erase(decode<ErrorMessage>(body).request);
      rest = rest.subspan(kFrameHeaderBytes + header.body_bytes);
    }
    session_.controlSent(control.size());
    require(session_.controlBytes() == 0);
    require(memory_.held() >= session_.openRequests() * kRequestBytes);
  }

  Script& script_;
  ServedSet served_{catalogOf(0), nullptr};
  MemoryAccount memory_;
  Clock::time_point now_{std::chrono::seconds(1000)};
  Session session_;
  std::vector<Chunk> parked_;
  uint64_t granted_ = kInitialWindowBytes, sent_bytes_ = 0;
  std::map<uint32_t, uint32_t> sent_;  ///< number of bytes sent so far, by open request
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  Script script(std::as_bytes(std::span(data, size)));
  // Room for everything, or for a few requests.
  MemoryBudget budget(script.byte() % 2 == 0 ? 1u << 30 : 2u << 10);
  Play(script, budget).run();
  require(budget.used() == 0);
  return 0;
}
