#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include <flatbuffers/flatbuffers.h>
#include <gtest/gtest.h>

#include "common/codec/texture_set.h"
#include "common/error.h"
#include "common/limits.h"
#include "proto/limits.h"
#include "proto/lodestream_generated.h"
#include "proto/messages.h"
#include "tests/unit/proto/sample_messages.h"

namespace lode::proto {
namespace {

using flatbuffers::FlatBufferBuilder;
using test::forEachSample;
using test::sampleSummary;

/// Builds a message body without the encoder's checks, as a hostile peer can.
template <typename Build>
Bytes craft(Build build) {
  FlatBufferBuilder builder;
  builder.Finish(build(builder));
  const auto* start = reinterpret_cast<const std::byte*>(builder.GetBufferPointer());
  return Bytes(start, start + builder.GetSize());
}

template <typename Message>
ErrorCode refusalOf(const Bytes& body) {
  try {
    decode<Message>(body);
  } catch (const Error& error) {
    return error.code();
  }
  ADD_FAILURE() << "the message was taken";
  return ErrorCode::kInternal;
}

template <typename Message>
Bytes bodyOf(const Message& message) {
  const Bytes frame = encode(message, 0);
  return Bytes(frame.begin() + kFrameHeaderBytes, frame.end());
}

/// Expects that decoding hostile bytes fails, or yields a valid message that encodes and decodes to the same
/// message.
template <typename Message>
void expectRefusedOrSound(const Bytes& body) {
  Message message;
  try {
    message = decode<Message>(body);
  } catch (const Error& error) {
    EXPECT_TRUE(error.code() == ErrorCode::kProtocol || error.code() == ErrorCode::kLimit) << error.what();
    return;
  }
  EXPECT_TRUE(decode<Message>(bodyOf(message)) == message);
}

TEST(HostileMessages, everyTruncationIsRefusedOrDecodes) {
  forEachSample([]<typename Message>(const Message& message) {
    const Bytes body = bodyOf(message);
    for (size_t size = 0; size < body.size(); ++size) {
      Bytes cut(body.begin(), body.begin() + static_cast<std::ptrdiff_t>(size));
      expectRefusedOrSound<Message>(cut);
    }
  });
}

TEST(HostileMessages, everyByteChangedIsRefusedOrDecodes) {
  std::mt19937 random(1);
  forEachSample([&]<typename Message>(const Message& message) {
    const Bytes body = bodyOf(message);
    for (size_t at = 0; at < body.size(); ++at)
      for (const int change : {0xFF, 0x80, 0x01, static_cast<int>(random() & 0xFF)}) {
        Bytes changed = body;
        changed[at] ^= static_cast<std::byte>(change);
        expectRefusedOrSound<Message>(changed);
      }
  });
}

TEST(HostileMessages, randomChangesAreRefusedOrDecode) {
  std::mt19937 random(2);
  forEachSample([&]<typename Message>(const Message& message) {
    const Bytes body = bodyOf(message);
    for (int round = 0; round < 3000; ++round) {
      Bytes changed = body;
      for (uint32_t changes = 1 + random() % 8; changes > 0; --changes)
        changed[random() % changed.size()] = static_cast<std::byte>(random());
      expectRefusedOrSound<Message>(changed);
    }
  });
}

TEST(HostileMessages, randomBytesAreRefusedOrDecode) {
  std::mt19937 random(3);
  for (int round = 0; round < 3000; ++round) {
    Bytes bytes(random() % 200);
    for (std::byte& byte : bytes) byte = static_cast<std::byte>(random() % 4 == 0 ? random() : 0);
    forEachSample([&]<typename Message>(const Message&) { expectRefusedOrSound<Message>(bytes); });
  }
}

TEST(HostileMessages, anEmptyBodyIsRefused) { EXPECT_EQ(refusalOf<Ping>({}), ErrorCode::kProtocol); }

TEST(HostileMessages, aBodyAboveTheLimitIsRefused) {
  EXPECT_EQ(refusalOf<Ping>(Bytes(kMaxFrameBodyBytes + 1)), ErrorCode::kLimit);
}

TEST(HostileMessages, aTokenAboveTheLimitIsRefused) {
  const auto hello = [](size_t token) {
    return craft([&](FlatBufferBuilder& b) {
      return wire::CreateHello(b, 1, 1, 0, b.CreateString(std::string(token, 'x')));
    });
  };
  EXPECT_EQ(decode<Hello>(hello(kMaxTokenBytes)).token.size(), kMaxTokenBytes);
  EXPECT_EQ(refusalOf<Hello>(hello(kMaxTokenBytes + 1)), ErrorCode::kLimit);
}

TEST(HostileMessages, aStringAboveTheLimitIsRefused) {
  const auto with = [](size_t length, auto create) {
    return craft([&](FlatBufferBuilder& b) { return create(b, b.CreateString(std::string(length, 'x'))); });
  };
  const auto hello = [](FlatBufferBuilder& b, auto s) { return wire::CreateHello(b, 1, 1, 0, 0, s); };
  const auto welcome = [](FlatBufferBuilder& b, auto s) { return wire::CreateWelcome(b, 1, 0, 0, s); };
  const auto error = [](FlatBufferBuilder& b, auto s) { return wire::CreateError(b, 1, 0, false, s); };
  const auto go_away = [](FlatBufferBuilder& b, auto s) { return wire::CreateGoAway(b, s); };
  EXPECT_NO_THROW(decode<Hello>(with(kMaxStringBytes, hello)));
  EXPECT_EQ(refusalOf<Hello>(with(kMaxStringBytes + 1, hello)), ErrorCode::kLimit);
  EXPECT_NO_THROW(decode<Welcome>(with(kMaxStringBytes, welcome)));
  EXPECT_EQ(refusalOf<Welcome>(with(kMaxStringBytes + 1, welcome)), ErrorCode::kLimit);
  EXPECT_NO_THROW(decode<ErrorMessage>(with(kMaxStringBytes, error)));
  EXPECT_EQ(refusalOf<ErrorMessage>(with(kMaxStringBytes + 1, error)), ErrorCode::kLimit);
  EXPECT_NO_THROW(decode<GoAway>(with(kMaxStringBytes, go_away)));
  EXPECT_EQ(refusalOf<GoAway>(with(kMaxStringBytes + 1, go_away)), ErrorCode::kLimit);
}

TEST(HostileMessages, aModelNameAboveTheLimitIsRefused) {
  const auto open = [](size_t length) {
    return craft(
        [&](FlatBufferBuilder& b) { return wire::CreateOpen(b, b.CreateString(std::string(length, 'x'))); });
  };
  EXPECT_EQ(decode<Open>(open(kMaxModelNameBytes)).model.size(), kMaxModelNameBytes);
  EXPECT_EQ(refusalOf<Open>(open(kMaxModelNameBytes + 1)), ErrorCode::kLimit);
}

TEST(HostileMessages, textWithTerminalControlsIsRefused) {
  const Bytes body = craft([](FlatBufferBuilder& b) {
    return wire::CreateError(b, 1, 0, false, b.CreateString("\x1b]0;title\x07"));
  });
  EXPECT_EQ(refusalOf<ErrorMessage>(body), ErrorCode::kProtocol);
}

Bytes requestsOf(size_t count) {
  return craft([&](FlatBufferBuilder& b) {
    // One table that is referenced many times: few bytes, but a large message if it were accepted.
    const std::vector changes(count, wire::CreateRequestChange(b, 0, 0, 1, 1, 1.0f));
    return wire::CreateRequests(b, 1, b.CreateVector(changes));
  });
}

TEST(HostileMessages, moreRequestsThanTheLimitAreRefused) {
  EXPECT_EQ(decode<Requests>(requestsOf(kMaxRequestsPerFrame)).changes.size(), kMaxRequestsPerFrame);
  EXPECT_EQ(refusalOf<Requests>(requestsOf(kMaxRequestsPerFrame + 1)), ErrorCode::kLimit);
}

flatbuffers::Offset<wire::ModelSummary> summaryTable(FlatBufferBuilder& b,
                                                     const std::function<void(ModelSummary&)>& change) {
  ModelSummary s = sampleSummary();
  change(s);
  const wire::Digest name;
  const wire::DVec3 origin(s.lattice.origin.x, s.lattice.origin.y, s.lattice.origin.z);
  const wire::LatticeBox box({s.box.min.x, s.box.min.y, s.box.min.z},
                             {s.box.max.x, s.box.max.y, s.box.max.z});
  return wire::CreateModelSummary(b, b.CreateString(s.name), &name, &origin, s.lattice.step, &box,
                                  s.attributes.bits, s.triangles, s.dropped, s.stored_triangles, s.nodes,
                                  s.payloads, s.bytes, s.depth, s.max_error_model, s.triangles_per_node,
                                  wire::CreateBlobRef(b, s.root_page.number, s.root_page.bytes, &name),
                                  wire::CreateBlobRef(b, s.textures.number, s.textures.bytes, &name));
}

TEST(HostileMessages, moreModelsThanTheLimitAreRefused) {
  const auto models = [](size_t count) {
    return craft([&](FlatBufferBuilder& b) {
      const std::vector list(count, summaryTable(b, [](ModelSummary&) {}));
      return wire::CreateModels(b, b.CreateVector(list));
    });
  };
  EXPECT_EQ(decode<Models>(models(kMaxListedModels)).models.size(), kMaxListedModels);
  EXPECT_EQ(refusalOf<Models>(models(kMaxListedModels + 1)), ErrorCode::kLimit);
}

Bytes openedWith(const std::function<void(ModelSummary&)>& change) {
  return craft([&](FlatBufferBuilder& b) { return wire::CreateOpened(b, 1, summaryTable(b, change)); });
}

TEST(HostileMessages, anInvalidSummaryIsRefused) {
  EXPECT_NO_THROW(decode<Opened>(openedWith([](ModelSummary&) {})));
  const double nan = std::nan("");
  const std::vector<std::function<void(ModelSummary&)>> lies{
      [](ModelSummary& s) { s.name.clear(); },
      [](ModelSummary& s) { s.name = "../\n"; },
      [](ModelSummary& s) { s.name = std::string(kMaxModelNameBytes + 1, 'x'); },
      [&](ModelSummary& s) { s.lattice.origin.y = nan; },
      [&](ModelSummary& s) { s.lattice.step = nan; },
      [](ModelSummary& s) { s.lattice.step = 0; },
      [](ModelSummary& s) { s.lattice.step = -1; },
      [](ModelSummary& s) { s.lattice.step = 0.3; },
      [](ModelSummary& s) { s.lattice.step = std::ldexp(1.0, -140); },
      [](ModelSummary& s) { s.lattice.step = std::ldexp(1.0, 120); },
      [](ModelSummary& s) { s.box.max.z = kMaxLattice + 1; },
      [](ModelSummary& s) { s.box.min.x = kMaxLattice + 1; },
      [](ModelSummary& s) { s.attributes.bits = 64; },
      [](ModelSummary& s) { s.nodes = kMaxNodes + 1; },
      [](ModelSummary& s) { s.depth = kMaxDepth + 1; },
      [](ModelSummary& s) { s.max_error_model = std::numeric_limits<float>::infinity(); },
      [](ModelSummary& s) { s.max_error_model = -1; },
      [](ModelSummary& s) { s.root_page.number = 0; },
      [](ModelSummary& s) { s.root_page.bytes = kMaxPageBytes + 1; },
      [](ModelSummary& s) { s.textures.number = 0; },
      [](ModelSummary& s) { s.textures.bytes = 0; },
      [](ModelSummary& s) { s.textures.bytes = kMaxTextureSetBytes + 1; },
  };
  for (size_t i = 0; i < lies.size(); ++i) EXPECT_THROW(decode<Opened>(openedWith(lies[i])), Error) << i;
}

TEST(HostileMessages, aMissingRequiredFieldIsRefused) {
  EXPECT_EQ(refusalOf<Opened>(craft([](FlatBufferBuilder& b) {
              const auto start = b.StartTable();
              return flatbuffers::Offset<wire::Opened>(b.EndTable(start));
            })),
            ErrorCode::kProtocol);
  EXPECT_EQ(refusalOf<Open>(craft([](FlatBufferBuilder& b) {
              const auto start = b.StartTable();
              return flatbuffers::Offset<wire::Open>(b.EndTable(start));
            })),
            ErrorCode::kProtocol);
}

Bytes requestWith(uint8_t action, uint8_t request_class, uint32_t request, float priority_px) {
  return craft([&](FlatBufferBuilder& b) {
    const std::vector changes{wire::CreateRequestChange(b, action, request_class, request, 1, priority_px)};
    return wire::CreateRequests(b, 1, b.CreateVector(changes));
  });
}

TEST(HostileMessages, anInvalidRequestIsRefused) {
  EXPECT_NO_THROW(decode<Requests>(requestWith(2, 2, 1, 0)));
  EXPECT_EQ(refusalOf<Requests>(requestWith(3, 0, 1, 0)), ErrorCode::kProtocol);
  EXPECT_EQ(refusalOf<Requests>(requestWith(0, 3, 1, 0)), ErrorCode::kProtocol);
  EXPECT_EQ(refusalOf<Requests>(requestWith(0, 0, 0, 0)), ErrorCode::kProtocol);
  EXPECT_EQ(refusalOf<Requests>(requestWith(0, 0, 1, std::nanf(""))), ErrorCode::kProtocol);
}

TEST(HostileMessages, anErrorWithACodeThatIsUnknownIsTakenAsInternal) {
  for (const uint8_t code : std::initializer_list<uint8_t>{0, 11, 255}) {
    const auto body = craft([&](FlatBufferBuilder& b) { return wire::CreateError(b, code, 7, true); });
    EXPECT_EQ(decode<ErrorMessage>(body), (ErrorMessage{WireError::kInternal, 7, true, ""}));
  }
}

TEST(HostileMessages, anInvalidVersionRangeIsRefused) {
  EXPECT_EQ(refusalOf<Hello>(bodyOf(Hello{0, 1, 0, "", ""})), ErrorCode::kProtocol);
  EXPECT_EQ(refusalOf<Hello>(bodyOf(Hello{3, 2, 0, "", ""})), ErrorCode::kProtocol);
  EXPECT_EQ(refusalOf<Welcome>(bodyOf(Welcome{0, 0, 0, ""})), ErrorCode::kProtocol);
}

TEST(HostileMessages, aHandleOfZeroIsRefused) {
  EXPECT_EQ(refusalOf<Opened>(craft([](FlatBufferBuilder& b) {
              return wire::CreateOpened(b, 0, summaryTable(b, [](ModelSummary&) {}));
            })),
            ErrorCode::kProtocol);
}

}  // namespace
}  // namespace lode::proto
